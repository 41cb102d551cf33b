// A mesh as binary glTF 2.0 (Khronos, The glTF 2.0 Specification, 2021): where its bytes lie.
//
// The file is a document in JSON, the vertices in rows and the triangles. All but the bounds of the
// vertices is known before the first row, and the document is padded to one length for all bounds:
// so every row has its place before anything is written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/vertex_colors.h"

namespace orbweave {

/// The largest GLB file: its length is a number of 32 bits.
inline constexpr std::uint64_t kMostGlbBytes = std::numeric_limits<std::uint32_t>::max();

/// Rows that are compressed as the extension EXT_meshopt_compression of glTF has them: its modes
/// ATTRIBUTES and TRIANGLES, without a filter.
struct PackedRows {
  std::string vertices;
  std::string triangles;
};

/// Vertices are rows of float positions about the origin, unit normals as floats where there are
/// normals, colours as four linear 16-bit fractions where there are all three colours, and floats
/// of the application's attributes. The node
/// of the mesh moves it to the origin's place, in doubles, and turns the axis that is upright to
/// glTF's y.
class GlbLayout final : public MeshRows {
 public:
  GlbLayout(const MeshHeader& header, const MeshWriterOptions& options);

  std::string front(const Box& bounds) const override;
  std::size_t vertex_bytes() const override { return vertex_bytes_; }
  std::size_t triangle_bytes() const override { return 3 * sizeof(std::uint32_t); }
  void put_vertices(const PointCloud& batch, std::byte* out) const override;
  void put_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t> hole,
                     std::byte* out) const override;

  /// The whole file, with rows that are compressed; readers have to know the extension.
  std::string packed_file(const Box& bounds, const PackedRows& rows) const;

  /// Of the whole file; may exceed what a file can have.
  std::uint64_t file_bytes() const;
  const MeshHeader& header() const { return header_; }

 private:
  /// A float attribute of the application.
  struct OwnAttribute {
    std::string name;        ///< of the file: "_HOLE"
    std::size_t offset = 0;  ///< among the attributes of a vertex
  };

  void find_own_attributes();
  /// `packed`: null where rows are as they are.
  std::string document(const Box& bounds, const PackedRows* packed = nullptr) const;
  std::uint64_t rows_bytes() const;

  MeshHeader header_;
  MeshWriterOptions options_;
  VertexColors colors_;
  std::vector<OwnAttribute> own_;
  std::size_t vertex_bytes_;
  std::size_t document_bytes_ = 0;
};

/// Names of the attributes that a GLB file has no place for. `own`: attributes of the application.
std::vector<std::string> columns_without_place_in_glb(const PointSchema& schema,
                                                      std::span<const std::string> own = {});

}  // namespace orbweave
