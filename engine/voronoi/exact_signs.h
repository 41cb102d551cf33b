// Which side of a plane, and of a sphere, a point lies on: decided by doubles where these are
// certain, by exact numbers otherwise.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "io/vec3.h"

namespace orbweave::voronoi {

/// Per axis the largest of some absolute differences.
class Extents {
 public:
  explicit Extents(Vec3 d) : x_(std::abs(d.x)), y_(std::abs(d.y)), z_(std::abs(d.z)) {}
  void add(Vec3 d) {
    x_ = std::max(x_, std::abs(d.x));
    y_ = std::max(y_, std::abs(d.y));
    z_ = std::max(z_, std::abs(d.z));
  }
  double volume() const { return x_ * y_ * z_; }
  double squared_diagonal() const { return x_ * x_ + y_ * y_ + z_ * z_; }
  /// Nothing overflows, and what underflows is far below the bounds of the errors.
  bool are_in_range() const {
    constexpr double kLeast = 0x1p-100, kMost = 0x1p100;
    return std::min({x_, y_, z_}) > kLeast && std::max({x_, y_, z_}) < kMost;
  }

 private:
  double x_, y_, z_;
};

/// The sign of a value that lies beyond its error; otherwise 0.
inline int sign_beyond(double value, double error) {
  return value > error ? 1 : value < -error ? -1 : 0;
}

/// 1 where a, b, c are counter-clockwise seen from d, -1 where clockwise; 0 where doubles cannot
/// tell.
inline int certain_plane_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Six terms, each at most the product of the extents, with at most 8 roundings of 2^-53 on the
  // way to each: the factor is their number, rounded up.
  constexpr double kError = 64.0 * 0x1p-53;
  const Vec3 u = b - a, v = c - a, w = d - a;
  Extents extents(u);
  extents.add(v);
  extents.add(w);
  const int sign = sign_beyond(dot(cross(u, v), w), kError * extents.volume());
  return extents.are_in_range() ? sign : 0;
}

/// The side of a sphere through positively oriented corners: 1 where p lies inside, -1 outside; 0
/// where doubles cannot tell.
inline int certain_sphere_side(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d,
                               const Vec3& p) {
  // 24 terms, each at most the volume times the squared diagonal, with at most 18 roundings of
  // 2^-53 on the way to each: the factor is their number, rounded up.
  constexpr double kError = 512.0 * 0x1p-53;
  const Vec3 e = a - p, f = b - p, g = c - p, h = d - p;
  Extents extents(e);
  extents.add(f);
  extents.add(g);
  extents.add(h);
  const double ef = e.x * f.y - f.x * e.y, eg = e.x * g.y - g.x * e.y, eh = e.x * h.y - h.x * e.y;
  const double fg = f.x * g.y - g.x * f.y, fh = f.x * h.y - h.x * f.y, gh = g.x * h.y - h.x * g.y;
  const double efg = ef * g.z - eg * f.z + fg * e.z, efh = ef * h.z - eh * f.z + fh * e.z;
  const double egh = eg * h.z - eh * g.z + gh * e.z, fgh = fg * h.z - fh * g.z + gh * f.z;
  const double determinant = (efh * squared_norm(g) - efg * squared_norm(h)) +
                             (fgh * squared_norm(e) - egh * squared_norm(f));
  const int sign = sign_beyond(determinant, kError * extents.volume() * extents.squared_diagonal());
  return extents.are_in_range() ? sign : 0;
}

/// The same as certain_plane_side(), exact: 0 in one plane.
int exact_plane_side(const std::array<Vec3, 4>& corners);

/// The same as certain_sphere_side(), exact, and never 0. Points on the sphere are told apart by
/// their coordinates: of the five the greatest in lexicographic order is taken to lie a little
/// outside, far more so than the next ones. Devillers, Teillaud, Perturbations for Delaunay and
/// Weighted Delaunay 3D Triangulations, 2011, section 4.
int exact_sphere_side(const std::array<Vec3, 4>& corners, Vec3 p);

}  // namespace orbweave::voronoi
