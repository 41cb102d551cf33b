// Which chords of a loop may be used, and how triangles bend and spread.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/triangulation/corner_triangle.h"
#include "engine/holes/triangulation/loop_in_space.h"
#include "io/vec3.h"

namespace orbweave {

using VertexPair = std::array<std::uint32_t, 2>;  ///< the smaller first

inline VertexPair vertex_pair(std::uint32_t a, std::uint32_t b) {
  return a < b ? VertexPair{a, b} : VertexPair{b, a};
}

class LoopChords {
 public:
  explicit LoopChords(const LoopInSpace& loop);

  /// For corners that are not successive.
  bool allows(std::uint32_t a, std::uint32_t b) const;
  /// Forbids the chords that a triangulation uses several times between the same vertices. False
  /// where there are none.
  bool forbid_repeated(std::span<const CornerTriangle> triangles);

 private:
  std::span<const std::uint32_t> vertices_;
  std::span<const VertexPair> forbidden_;
  std::span<const std::array<std::uint32_t, 2>> apart_;
  std::vector<VertexPair> more_;  ///< rim edges and repeated chords; only of loops that touch
  bool touches_ = false;          ///< some vertex is visited several times
};

/// Unit normal and area of a triangle. No normal where it has no area to speak of.
struct Facet {
  Vec3 normal;
  double area = 0.0;
};
inline Facet facet(Vec3 a, Vec3 b, Vec3 c) {
  // Area below this share of the longest edge's square is rounding.
  constexpr double kFlat = 1e-10;
  const Vec3 normal = cross(b - a, c - a);
  const double doubled = norm(normal);
  const double longest = std::max({squared_norm(b - a), squared_norm(c - b), squared_norm(a - c)});
  if (!(doubled > kFlat * longest)) return {Vec3{}, 0.5 * doubled};
  return {normal / doubled, 0.5 * doubled};
}

/// The least cost triangulation of the corners `ring` of the loop, in its order; `behind[i]` is the
/// normal behind the edge from ring[i] to the next. Appends to `out`; false where there is none.
/// O(n^3) time and 64 n^2 bytes; up to kLeastBendCorners corners O(n^4) and 64 n^3 bytes, and the
/// largest bend is then the least possible.
bool triangulate_exactly(const LoopInSpace& loop, const LoopChords& chords,
                         std::span<const std::uint32_t> ring, std::span<const Vec3> behind,
                         std::vector<CornerTriangle>& out);

/// Cuts ears off the loop until `keep` corners are left or none can be cut. Appends to `out`.
struct LoopRest {
  std::vector<std::uint32_t> ring;
  std::vector<Vec3> behind;
};
LoopRest cut_ears(const LoopInSpace& loop, const LoopChords& chords, std::uint32_t keep,
                  std::vector<CornerTriangle>& out);

}  // namespace orbweave
