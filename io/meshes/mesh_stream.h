// A mesh read once, front to back.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "io/streams/byte_reader.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// What a file says of a triangle that may fill a hole.
struct FacePatch {
  std::int32_t hole = 0;    ///< the hole's id; 0: scanned surface
  float confidence = 1.0F;  ///< of the patch; 1: scanned surface, or not known
  friend auto operator<=>(const FacePatch&, const FacePatch&) = default;
};

/// All vertices, then all triangles, in the file's order. Damaged files end in an Error (bad
/// input) with file and place.
class MeshStream {
 public:
  virtual ~MeshStream() = default;
  virtual const PointSchema& schema() const = 0;
  virtual std::uint64_t vertices() const = 0;
  /// Faces of the file; those of more than three corners give more triangles.
  virtual std::uint64_t faces() const = 0;
  /// Replaces `batch` by the next vertices, at most `capacity`. False, with an empty batch, at the
  /// end.
  virtual bool read_vertices(PointCloud& batch, std::size_t capacity) = 0;
  /// Replaces `batch` by the next triangles, after the last vertex; false at the end. Corners are
  /// below vertices(). A face of many corners may exceed the capacity.
  virtual bool read_triangles(std::vector<Triangle64>& batch, std::size_t capacity) = 0;
  /// Whether faces say which hole they fill (`hole`), and how sure the patch is (`confidence`).
  virtual bool has_holes() const { return false; }
  virtual bool has_confidence() const { return false; }
  /// One for each triangle of the last batch; empty where faces have no `hole`.
  virtual std::span<const FacePatch> patches() const { return {}; }
  /// What the file holds beside that, in words, as read_mesh() tells it. Faces that are no surface
  /// are among it where they are known: at the end of a stream.
  virtual std::vector<std::string> left_out() const { return {}; }
};

/// PLY whose vertices come before its faces, in bounded memory; null for other PLY. Coordinates are
/// counted from `origin`. Throws Error (bad input) where the header is damaged or the file is too
/// short for it.
std::unique_ptr<MeshStream> ply_mesh_stream(ByteReader reader, Vec3 origin = {});

/// PLY of any size whose vertices come before its faces is read in bounded memory; OBJ, STL and
/// other PLY files are held in memory. Coordinates counted from an origin, by the shift beside the
/// file, are those of the world. Throws Error as read_mesh() does, and (bad input) for a file
/// without faces.
std::unique_ptr<MeshStream> open_mesh_stream(const std::filesystem::path& path);

/// The confidence of each triangle of a file; empty where its faces have none.
std::vector<float> face_confidence(const std::filesystem::path& path);
/// The confidence of each patch of a file by the id of its hole; empty where its faces have none.
std::map<std::int32_t, float> hole_confidence(const std::filesystem::path& path);

}  // namespace orbweave
