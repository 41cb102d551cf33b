// Loops in space for tests of triangulations and patches.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/holes/triangulation/loop_triangulation.h"
#include "tests/support/clouds.h"

namespace orbweave::test {

struct Loop {
  std::vector<Vec3> corners;
  std::vector<std::uint32_t> vertices;
  std::vector<Vec3> rim_normals;
  std::vector<std::array<std::uint32_t, 2>> forbidden;

  LoopInSpace view() const { return {corners, vertices, rim_normals, forbidden}; }
};

/// A circle of radius 1 in the plane z = 0, its height changed by `wave` three times around.
Loop wavy_circle(std::uint32_t corners, double wave);
/// Corners at random distances and heights, in all directions.
Loop random_loop(std::uint32_t corners, double height, Random& random);
/// A cycle on the surface of a sphere, with its faces' normals: the rim of a cap.
Loop cap_rim(std::uint32_t corners, double polar_angle);
Loop moved(Loop loop, double scale, Vec3 offset);

double area_of(const std::vector<Vec3>& positions, const std::vector<CornerTriangle>& triangles);

}  // namespace orbweave::test
