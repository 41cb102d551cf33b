// The shapes of `generate` in the plainest formulas there are, apart from the program's own.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "engine/synthetic/portable_math.h"
#include "engine/synthetic/synthetic_cloud.h"

namespace orbweave::test {

/// An implicit function of the surface, zero on it and growing outward.
inline double implicit(Shape shape, double gap, Vec3 p) {
  const double from_axis = std::hypot(p.x, p.y);
  switch (shape) {
    case Shape::kSphere:
      return norm(p) - 1.0;
    case Shape::kTorus:
      return std::hypot(from_axis - 1.0, p.z) - 0.4;
    case Shape::kBumpyTorus: {
      const double u = std::atan2(p.y, p.x);
      const double v = std::atan2(p.z, from_axis - 1.0);
      const double turn = 2.0 * portable::kPi;
      return std::hypot(from_axis - 1.0, p.z) -
             0.4 * (1.0 + 0.10 * std::sin(5 * u) + 0.06 * std::sin(4 * v + 0.1 * turn) +
                    0.05 * std::sin(8 * u + 3 * v + 0.3 * turn));
    }
    case Shape::kPlane:
      return p.z;
    case Shape::kDoubleWall:
      return std::abs(p.z - 0.5 * gap) - 0.5 * gap;
    case Shape::kCube:
      return std::max({std::abs(p.x - 0.5), std::abs(p.y - 0.5), std::abs(p.z - 0.5)}) - 0.5;
    case Shape::kTwoComponents:
      return std::min(norm(p - Vec3{0.0, 0.0, 1.2}) - 0.5, std::hypot(from_axis - 1.0, p.z) - 0.4);
    case Shape::kGenusThree: {
      double beside = from_axis - 1.3;
      for (int k = 0; k < 3; ++k) {
        const double turn = 2.0 * portable::kPi * k / 3.0;
        beside = std::max(
            beside, 0.4 - std::hypot(p.x - 0.65 * std::cos(turn), p.y - 0.65 * std::sin(turn)));
      }
      return (beside > 0.0 ? std::hypot(beside, p.z) : std::abs(p.z)) - 0.2;
    }
  }
  return 0.0;
}

inline Vec3 implicit_gradient(Shape shape, double gap, Vec3 p) {
  constexpr double kStep = 1e-5;
  Vec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 ahead = p, behind = p;
    ahead[axis] += kStep;
    behind[axis] -= kStep;
    gradient[axis] = implicit(shape, gap, ahead) - implicit(shape, gap, behind);
  }
  return normalized(gradient);
}

/// Hash of the bits of all positions and, where there are any, normals.
inline std::uint64_t fingerprint(const PointCloud& cloud) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a over the bits, low byte first
  const auto add = [&](double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    for (int i = 0; i < 8; ++i) hash = (hash ^ ((bits >> (8 * i)) & 255)) * 1099511628211u;
  };
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      add(cloud.positions[i][axis]);
      if (!cloud.normals.empty()) add(cloud.normals[i][axis]);
    }
  return hash;
}

}  // namespace orbweave::test
