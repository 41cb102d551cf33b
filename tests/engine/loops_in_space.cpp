#include "tests/engine/loops_in_space.h"

#include <cmath>
#include <numbers>
#include <numeric>

namespace orbweave::test {
namespace {

Loop with_own_vertices(std::vector<Vec3> corners) {
  Loop loop;
  loop.corners = std::move(corners);
  loop.vertices.resize(loop.corners.size());
  std::iota(loop.vertices.begin(), loop.vertices.end(), 0U);
  return loop;
}

}  // namespace

Loop wavy_circle(std::uint32_t corners, double wave) {
  std::vector<Vec3> positions;
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / corners;
    positions.push_back({std::cos(angle), std::sin(angle), wave * std::cos(3.0 * angle)});
  }
  return with_own_vertices(positions);
}

Loop random_loop(std::uint32_t corners, double height, Random& random) {
  std::vector<Vec3> positions;
  for (std::uint32_t i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5 * random.uniform()) / corners;
    const double radius = 0.5 + 0.5 * random.uniform();
    positions.push_back(
        {radius * std::cos(angle), radius * std::sin(angle), height * random.bell()});
  }
  return with_own_vertices(positions);
}

Loop cap_rim(std::uint32_t corners, double polar_angle) {
  Loop loop = wavy_circle(corners, 0.0);
  for (Vec3& p : loop.corners) {
    p = {std::sin(polar_angle) * p.x, std::sin(polar_angle) * p.y, std::cos(polar_angle)};
  }
  for (std::uint32_t i = 0; i < corners; ++i) {
    loop.rim_normals.push_back(normalized(loop.corners[i] + loop.corners[(i + 1) % corners]));
  }
  return loop;
}

Loop moved(Loop loop, double scale, Vec3 offset) {
  for (Vec3& p : loop.corners) p = scale * p + offset;
  return loop;
}

double area_of(const std::vector<Vec3>& positions, const std::vector<CornerTriangle>& triangles) {
  double area = 0.0;
  for (const CornerTriangle& t : triangles) {
    const Vec3 a = positions[t[0]];
    area += 0.5 * norm(cross(positions[t[1]] - a, positions[t[2]] - a));
  }
  return area;
}

}  // namespace orbweave::test
