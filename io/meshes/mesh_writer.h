// Meshes and clouds to files, streaming, in bounded memory, never half-written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

struct MeshWriterOptions {
  bool binary = true;            ///< PLY and STL: binary or text
  bool float_positions = false;  ///< PLY, VTP, XDMF: float instead of double coordinates
  Vec3 origin{};                 ///< is subtracted from positions
  Vec3 node_offset{};            ///< GLB: the node adds it to the origin's place
  int up_axis = 2;               ///< GLB: the axis that is upright; 0: x, 1: y, 2: z
  /// GLB: names of float attributes that become attributes of the application ("hole": "_HOLE").
  std::vector<std::string> glb_attributes{};
  std::vector<std::string> comments;  ///< PLY header comments
  /// PLY with `hole`: adds the per-face float `confidence`, 1 of scanned faces, else that of the
  /// hole with this id (from 1 on; of ids beyond, 1).
  bool has_confidence = false;
  std::vector<float> confidence{};
};

/// What a writer needs to know before the first byte.
struct MeshHeader {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool is_cloud = false;  ///< no face element at all
  bool has_hole = false;  ///< per-face int `hole`
  PointSchema schema;     ///< what the vertices carry
  /// Most corners of a face. Where it is not 3, `triangles` counts polygons.
  std::uint32_t most_corners = 3;
};

/// A format that is a front and rows of the same width, so that the place of every row is known
/// before anything is written. Thread-safe; nothing in it changes.
class MeshRows {
 public:
  virtual ~MeshRows() = default;
  /// The bytes before the rows: the same number for any bounds. `bounds`: of all vertices, before
  /// the origin is subtracted; empty where they are not known yet.
  virtual std::string front(const Box& bounds) const = 0;
  virtual std::size_t vertex_bytes() const = 0;
  virtual std::size_t triangle_bytes() const = 0;
  /// Write one row each, the batch one after another. The batch has the header's columns.
  virtual void put_vertices(const PointCloud& batch, std::byte* out) const = 0;
  virtual void put_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t> hole,
                             std::byte* out) const = 0;
};

/// The format of a file of that name as rows: binary PLY and GLB. Null where it has none (text,
/// compressed files, OBJ, STL, standard output).
std::unique_ptr<MeshRows> mesh_rows(const std::filesystem::path& path, const MeshHeader& header,
                                    const MeshWriterOptions& options = {});

/// Faces of any number of corners: those of face f are `corners[begin[f]]` to
/// `corners[begin[f + 1]]` (exclusive).
struct PolygonFaces {
  std::vector<std::uint32_t> corners;
  std::vector<std::uint32_t> begin = {0};

  std::size_t size() const { return begin.size() - 1; }
  std::span<const std::uint32_t> of(std::size_t face) const {
    return std::span(corners).subspan(begin[face], begin[face + 1] - begin[face]);
  }
};

/// Writes one file: header, then all vertices, then all triangles, then finish(). The file
/// appears under its name only in finish(); destroyed earlier, nothing stays behind.
/// Throws Error (resource) where it cannot be written, with path and the system's reason.
/// A writer is for one thread at a time, but for encode_*, which any threads may call meanwhile.
class MeshWriter {
 public:
  virtual ~MeshWriter() = default;
  /// Batches may have any size; their sum must equal the header's counts. Serialising is a pure
  /// function of the batch, so callers may prepare bytes in parallel with encode_* and pass
  /// them, in order, to write_encoded.
  virtual void write_vertices(const PointCloud& batch) = 0;
  virtual void write_triangles(std::span<const Triangle64> batch,
                               std::span<const std::int32_t> hole = {}) = 0;
  /// For formats whose bytes do not depend on what came before (PLY, OBJ); empty otherwise.
  virtual bool encodes_independently() const { return false; }
  virtual std::vector<std::byte> encode_vertices(const PointCloud&) const { return {}; }
  virtual std::vector<std::byte> encode_triangles(std::span<const Triangle64>,
                                                  std::span<const std::int32_t>) const {
    return {};
  }
  virtual void write_encoded_vertices(std::span<const std::byte>, std::uint64_t /*vertices*/) {}
  virtual void write_encoded_triangles(std::span<const std::byte>, std::uint64_t /*triangles*/) {}
  /// In place of triangles, all at once. Throws std::logic_error where the format has none.
  virtual void write_polygons(const PolygonFaces& faces);
  virtual void finish() = 0;
  virtual std::uint64_t bytes_written() const = 0;
};

/// Writer by extension: .ply .obj .stl .glb .vtp .xdmf for meshes; .ply .xyz .csv for clouds, each
/// cloud format also with .gz. "-" writes PLY to standard output. Usage error for anything else.
std::unique_ptr<MeshWriter> open_mesh_writer(const std::filesystem::path& path,
                                             const MeshHeader& header,
                                             const MeshWriterOptions& options = {});

/// Names of what vertices of this schema carry and a file of that name has no place for; "normals"
/// for these.
std::vector<std::string> columns_without_place(const std::filesystem::path& path,
                                               const PointSchema& schema);

/// Likewise of faces that fill holes: "hole (of faces)", "confidence (of faces)" where they have
/// it.
std::vector<std::string> patches_without_place(const std::filesystem::path& path,
                                               bool has_confidence);

/// Whether the coordinates of such a file are floats.
bool has_float_coordinates(const std::filesystem::path& path, const MeshWriterOptions& options);

/// Throws Error (usage) where the format cannot hold a mesh of this size.
void check_mesh_size(const std::filesystem::path& path, const MeshHeader& header,
                     const MeshWriterOptions& options);

/// Whether a file of that name can hold polygons: PLY and OBJ.
bool holds_polygons(const std::filesystem::path& path);

/// Writes a mesh of polygons, as PLY or OBJ by extension. Usage error for anything else. Faces of a
/// PLY file are lists counted by `uchar`, or by `int` where one has more than 255 corners.
void write_polygons(const std::filesystem::path& path, const PointCloud& vertices,
                    const PolygonFaces& faces, const MeshWriterOptions& options = {});

/// Writes a whole mesh or cloud in one call. Throws Error (usage) where its columns do not belong
/// together, where the format has no text and one is asked for, and where the HDF5 file of an
/// .xdmf would replace a file that is no mesh.
void write_mesh(const std::filesystem::path& path, const TriangleMesh& mesh,
                const MeshWriterOptions& options = {});
void write_cloud(const std::filesystem::path& path, const PointCloud& cloud,
                 const MeshWriterOptions& options = {});

}  // namespace orbweave
