#include "engine/cleaning/points_near.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "io/whole_loop.h"

namespace orbweave {
namespace {

std::int64_t floor_of(std::int64_t number, std::int64_t step) {
  const std::int64_t quotient = number / step;
  return number % step < 0 ? quotient - 1 : quotient;
}

/// The cube of a lattice that is `step` times as coarse.
LatticeCell coarse(const LatticeCell& cube, std::int64_t step) {
  return {floor_of(cube.z, step), floor_of(cube.y, step), floor_of(cube.x, step)};
}

void sort_out(std::vector<LatticeCell>& cubes) {
  std::sort(cubes.begin(), cubes.end());
  cubes.erase(std::unique(cubes.begin(), cubes.end()), cubes.end());
}

std::vector<std::uint32_t> all_points(std::size_t count) {
  std::vector<std::uint32_t> points(count);
  std::iota(points.begin(), points.end(), 0u);
  return points;
}

/// These cubes and all that touch them, ascending.
std::vector<LatticeCell> with_neighbors(std::vector<LatticeCell> cubes) {
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

PointRuns::PointRuns(std::span<const Vec3> positions, double side) : side_(side) {
  constexpr std::size_t kGrain = 16384;
  std::vector<std::vector<Run>> of_part((positions.size() + kGrain - 1) / kGrain);
  for_each_whole(of_part.size(), [&](std::size_t part) {
    std::vector<Run>& runs = of_part[part];
    const std::size_t end = std::min(positions.size(), (part + 1) * kGrain);
    for (auto i = static_cast<std::uint32_t>(part * kGrain); i < end; ++i) {
      const LatticeCell cube = cube_of(positions[i], side);
      if (runs.empty() || runs.back().cube != cube) runs.push_back({cube, i, i});
      ++runs.back().end;
    }
  });
  for (const std::vector<Run>& runs : of_part) {
    auto first = runs.begin();
    if (!runs_.empty() && runs_.back().cube == first->cube) runs_.back().end = (first++)->end;
    runs_.insert(runs_.end(), first, runs.end());
  }
}

std::vector<std::uint32_t> PointRuns::near(std::span<const std::uint8_t> wanted,
                                           double reach) const {
  const auto count = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), 1));
  if (2 * count > wanted.size()) return all_points(wanted.size());
  constexpr double kRounding = 1.01;
  const auto step =
      std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(kRounding * reach / side_)));
  std::vector<LatticeCell> cubes;
  for (const Run& run : runs_) {
    const auto flags = wanted.subspan(run.begin, run.end - run.begin);
    if (std::memchr(flags.data(), 1, flags.size()) == nullptr) continue;
    const LatticeCell cube = coarse(run.cube, step);
    if (cubes.empty() || cubes.back() != cube) cubes.push_back(cube);
  }
  const std::vector<LatticeCell> around = with_neighbors(std::move(cubes));
  std::vector<std::uint32_t> points;
  LatticeCell last;
  bool is_near = false;
  for (const Run& run : runs_) {
    const LatticeCell cube = coarse(run.cube, step);
    if (run.begin == 0 || cube != last)
      is_near = std::binary_search(around.begin(), around.end(), cube);
    last = cube;
    for (std::uint32_t i = run.begin; i < run.end && is_near; ++i) points.push_back(i);
  }
  return points;
}

}  // namespace orbweave
