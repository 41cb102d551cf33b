// The fingerprint of a surface, computed part by part.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "io/triangle_mesh.h"

namespace orbweave {

/// XXH3-64 over four words: the sum over all vertices of XXH3-64 of (number, x, y, z), the number
/// of vertices, the sum over all triangles of XXH3-64 of (number, three vertex numbers), the number
/// of triangles. Numbers count from 0 in the file's order; coordinates are doubles, -0 as 0; words
/// are 64 bits, little-endian; sums are modulo 2^64. Sums do not mind the order of their terms, so
/// parts of a mesh may be added in any order, and by several threads or processes, each to a
/// checksum of its own.
///
/// Callers add the vertices that triangles use, in file order, and number the triangles' corners
/// among those. The checksum thus depends on the surface alone: not on normals, attributes, file
/// format or stray points.
class MeshChecksum {
 public:
  /// Vertices that follow one another; `first`: the number of the first of them.
  void add_vertices(std::span<const Vec3> positions, std::uint64_t first);
  void add_triangles(std::span<const Triangle64> triangles, std::uint64_t first);
  /// What was added to another checksum.
  void add(const MeshChecksum& other);
  /// 16 lower-case hexadecimal digits of what was added so far.
  std::string hex() const;

  /// The sums and counts for another process, and back.
  std::string state() const;
  static std::optional<MeshChecksum> from_state(std::string_view state);

 private:
  struct Sum {
    std::uint64_t hashes = 0;
    std::uint64_t rows = 0;
  };
  Sum vertices_, triangles_;
};

}  // namespace orbweave
