// Which synthetic surface is sampled, and how.
#pragma once

#include <cstdint>

#include "io/point_cloud.h"

namespace orbweave {

/// World units; every surface is about 1 to 3 units large.
enum class Shape {
  kSphere,         ///< radius 1 around the origin
  kTorus,          ///< around the z axis, radii 1 and 0.4
  kBumpyTorus,     ///< the torus, its tube radius modulated by three sines (together at most 21 %)
  kPlane,          ///< unit square in z = 0, normals up, straight border
  kDoubleWall,     ///< two unit squares three spacings apart, normals outward, open at the sides
  kCube,           ///< [0, 1]^3 with points on edges and corners
  kTwoComponents,  ///< the torus, and above it a sphere of radius 0.5 around (0, 0, 1.2)
  kGenusThree      ///< around the z axis, a plate of radius 1.5 with three holes and round rims
};

struct SyntheticOptions {
  Shape shape = Shape::kSphere;
  std::uint64_t points = 10'000;  ///< exactly so many; at least 1
  /// Standard deviation of each coordinate's noise, in units of spacing(); >= 0. Isotropic and
  /// nearly Gaussian; normals stay those of the undisturbed surface.
  double noise = 0.0;
  /// Density varies 1:16 from one end of the shape to the other: growing with z (sphere, cube),
  /// with y (plane, double wall), from the inner to the outer equator (tori), from the holes to the
  /// outer rim (genus 3); in each of two components. Locally the points stay near-uniform.
  bool density_varying = false;
  std::uint64_t seed = 1;                       ///< of the noise
  ScalarType precision = ScalarType::kFloat64;  ///< of positions and normals; or kFloat32
};

}  // namespace orbweave
