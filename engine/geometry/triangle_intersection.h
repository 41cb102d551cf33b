// Whether triangles of a mesh intersect, decided exactly.
// Shewchuk: Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates,
// Discrete & Computational Geometry 18, 1997 (expansions, error bounds); Guigue, Devillers: Fast
// and Robust Triangle-Triangle Overlap Test Using Orientation Predicates, 2003.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// The sign of the volume of the tetrahedron: 1 when d lies on the side of abc from which a, b, c
/// run clockwise, -1 on the other, 0 in their plane. Exact as long as nothing under- or overflows.
int side_of_plane(Vec3 a, Vec3 b, Vec3 c, Vec3 d);

/// True when two different triangles of a mesh have more in common than the vertices and the edge
/// that they share by index: closed triangles that touch otherwise, and neighbours over an edge
/// that are folded onto each other. A triangle whose corners lie on a line is a segment. Exact.
bool triangles_intersect(std::span<const Vec3> positions, const Triangle& s, const Triangle& t);

/// As triangles_intersect, of triangles without a common vertex, from what is known of them: on
/// which side of the other one's plane each corner lies, as side_of_plane has it. Precondition: no
/// side is 0, and not all corners of a triangle lie on one side.
bool triangles_across_intersect(const std::array<Vec3, 3>& s, const std::array<Vec3, 3>& t,
                                const std::array<int, 3>& sides_of_s,
                                const std::array<int, 3>& sides_of_t);

/// The plane through three points, by which doubles tell most places apart.
class QuickPlane {
 public:
  static constexpr int kUnknown = 2;

  QuickPlane(Vec3 a, Vec3 b, Vec3 c);

  /// As side_of_plane(); kUnknown where doubles cannot tell.
  int side(Vec3 p) const {
    const Vec3 d = p - from_;
    const double height = dot(normal_, d);
    const double bound = bound_ * (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
    return height > bound ? -1 : height < -bound ? 1 : kUnknown;
  }

 private:
  Vec3 from_, normal_;
  double bound_ = 0.0;  ///< what a height may be off by, per unit of the place's distance
};

/// A triangle that others are held against: its plane tells that most of them do not intersect it.
class ApartByPlane {
 public:
  ApartByPlane(std::span<const Vec3> positions, const Triangle& triangle)
      : triangle_(triangle),
        plane_(positions[triangle[0]], positions[triangle[1]], positions[triangle[2]]) {}

  /// True where the corners of another triangle that are not its own lie strictly on one side of
  /// its plane, and there are such: the two do not intersect (triangles_intersect()). Quick; false
  /// proves nothing.
  bool has_beside(std::span<const Vec3> positions, const Triangle& other) const {
    int side = 0;
    for (const std::uint32_t v : other) {
      if (v == triangle_[0] || v == triangle_[1] || v == triangle_[2]) continue;
      const int here = plane_.side(positions[v]);
      if (here == QuickPlane::kUnknown || here == -side) return false;
      side = here;
    }
    return side != 0;
  }

 private:
  Triangle triangle_;
  QuickPlane plane_;
};

/// Whether the closed segment pq meets the closed triangle abc. Exact.
bool segment_meets_triangle(Vec3 p, Vec3 q, Vec3 a, Vec3 b, Vec3 c);

}  // namespace orbweave
