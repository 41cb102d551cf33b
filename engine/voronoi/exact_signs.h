// Which side of a plane, and of a sphere, a point lies on: decided by doubles where these are
// certain, by exact numbers otherwise.
#pragma once

#include <array>
#include <span>

#include "io/vec3.h"

namespace orbweave::voronoi {

/// An offset in space, or several side by side where the numbers are vectors.
template <class Number>
struct Offset {
  Number x, y, z;
};

/// A sum and the square of what rounding can have made of it.
template <class Number>
struct RoundedSum {
  Number value, squared_error;
};

/// The least squared error that hides whatever underflows in sums over points: infinite where
/// coordinates are so large that there is none.
double least_squared_error(std::span<const Vec3> points);

/// Whether the sign of a sum is certain, which that of no number is not.
template <class Number>
auto certain(const RoundedSum<Number>& sum, double least_squared_error) {
  return (sum.value * sum.value > sum.squared_error) & (sum.squared_error > least_squared_error);
}

/// The sign of a sum where it is certain; otherwise 0.
inline int certain_sign(const RoundedSum<double>& sum, double least_squared_error) {
  return certain(sum, least_squared_error) ? (sum.value > 0.0 ? 1 : -1) : 0;
}

/// Above 0 where p lies inside the sphere of four positively oriented corners, given as offsets
/// from p.
template <class Number>
RoundedSum<Number> sphere_sum(const std::array<Offset<Number>, 4>& corners) {
  // 24 terms, each at most the product of the largest of x, y, z and the largest square, with at
  // most 18 roundings of 2^-53 on the way to each: the factor is their number, rounded up. The sums
  // of squares below are at least the squares of the largest.
  constexpr double kError = 512.0 * 0x1p-53;
  const auto& [e, f, g, h] = corners;
  const Number ex = e.x * e.x, ey = e.y * e.y, ez = e.z * e.z;
  const Number fx = f.x * f.x, fy = f.y * f.y, fz = f.z * f.z;
  const Number gx = g.x * g.x, gy = g.y * g.y, gz = g.z * g.z;
  const Number hx = h.x * h.x, hy = h.y * h.y, hz = h.z * h.z;
  const Number ef = e.x * f.y - f.x * e.y, eg = e.x * g.y - g.x * e.y, eh = e.x * h.y - h.x * e.y;
  const Number fg = f.x * g.y - g.x * f.y, fh = f.x * h.y - h.x * f.y, gh = g.x * h.y - h.x * g.y;
  const Number efg = ef * g.z - eg * f.z + fg * e.z, efh = ef * h.z - eh * f.z + fh * e.z;
  const Number egh = eg * h.z - eh * g.z + gh * e.z, fgh = fg * h.z - fh * g.z + gh * f.z;
  const Number x = ex + fx + gx + hx, y = ey + fy + gy + hy, z = ez + fz + gz + hz;
  const Number square = kError * (x + y + z);
  return {
      (efh * (gx + gy + gz) - efg * (hx + hy + hz)) + (fgh * (ex + ey + ez) - egh * (fx + fy + fz)),
      (x * y * z) * (square * square)};
}

/// Above 0 where three corners are counter-clockwise seen from p, given as offsets from p.
template <class Number>
RoundedSum<Number> plane_sum(const Offset<Number>& a, const Offset<Number>& b,
                             const Offset<Number>& c) {
  // Six terms, each at most the product of the largest of x, y, z, with at most 8 roundings of
  // 2^-53 on the way to each. The sums of squares are at least the squares of the largest.
  constexpr double kError = 64.0 * 0x1p-53;
  const Number x = a.x * a.x + b.x * b.x + c.x * c.x;
  const Number y = a.y * a.y + b.y * b.y + c.y * c.y;
  const Number z = a.z * a.z + b.z * b.z + c.z * c.z;
  return {
      a.x * (c.y * b.z - b.y * c.z) + a.y * (b.x * c.z - c.x * b.z) + a.z * (c.x * b.y - b.x * c.y),
      (x * y * z) * (kError * kError)};
}

/// 1 where the first three corners are counter-clockwise seen from the fourth, -1 where clockwise,
/// 0 in one plane. Exact.
int exact_plane_side(const std::array<Vec3, 4>& corners);

/// 1 where p lies inside the sphere of positively oriented corners, -1 outside. Exact, and never 0:
/// points on the sphere are told apart by
/// their coordinates: of the five the greatest in lexicographic order is taken to lie a little
/// outside, far more so than the next ones. Devillers, Teillaud, Perturbations for Delaunay and
/// Weighted Delaunay 3D Triangulations, 2011, section 4.
int exact_sphere_side(const std::array<Vec3, 4>& corners, Vec3 p);

}  // namespace orbweave::voronoi
