#include "engine/cleaning/points_near.h"

#include <algorithm>

#include "engine/geometry/lattice_cube.h"

namespace orbweave {
namespace {

void sort_out(std::vector<LatticeCell>& cubes) {
  std::sort(cubes.begin(), cubes.end());
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
}

/// The cubes of the points that are wanted and those around them, ascending.
std::vector<LatticeCell> cubes_around(std::span<const Vec3> positions,
                                      std::span<const std::uint8_t> wanted, double side) {
  std::vector<LatticeCell> cubes;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (wanted[i] == 0) continue;
    const LatticeCell cube = cube_of(positions[i], side);
    if (cubes.empty() || cubes.back() != cube) cubes.push_back(cube);
  }
  sort_out(cubes);
  std::vector<LatticeCell> around;
  around.reserve(27 * cubes.size());
  for (const LatticeCell& cube : cubes)
    for (std::int64_t z = -1; z <= 1; ++z)
      for (std::int64_t y = -1; y <= 1; ++y)
        for (std::int64_t x = -1; x <= 1; ++x)
          around.push_back({cube.z + z, cube.y + y, cube.x + x});
  sort_out(around);
  return around;
}

}  // namespace

std::vector<std::uint32_t> points_near(std::span<const Vec3> positions,
                                       std::span<const std::uint8_t> wanted, double reach) {
  constexpr double kSidePerReach = 1.01;  // in spite of rounding
  const double side = kSidePerReach * reach;
  const std::vector<LatticeCell> cubes = cubes_around(positions, wanted, side);
  std::vector<std::uint32_t> near;
  LatticeCell last;
  bool is_near = false;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    const LatticeCell cube = cube_of(positions[i], side);
    if (i == 0 || cube != last) is_near = std::binary_search(cubes.begin(), cubes.end(), cube);
    last = cube;
    if (is_near) near.push_back(i);
  }
  return near;
}

NearPart part_of(std::vector<std::uint32_t> points, std::span<const Vec3> positions,
                  std::span<const Vec3> normals, std::uint32_t begin, std::uint32_t end) {
  NearPart part;
  part.positions.reserve(points.size());
  for (const std::uint32_t i : points) part.positions.push_back(positions[i]);
  if (!normals.empty()) {
    part.normals.reserve(points.size());
    for (const std::uint32_t i : points) part.normals.push_back(normals[i]);
  }
  const auto row_of = [&](std::uint32_t point) {
    return static_cast<std::uint32_t>(std::lower_bound(points.begin(), points.end(), point) -
                                      points.begin());
  };
  part.begin = row_of(begin);
  part.end = row_of(end);
  part.points = std::move(points);
  return part;
}

}  // namespace orbweave
