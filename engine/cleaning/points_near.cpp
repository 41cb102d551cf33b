#include "engine/cleaning/points_near.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <utility>

#include "engine/geometry/cell_rows.h"
#include "engine/geometry/neighbor_grid.h"
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

constexpr std::uint32_t kGrain = 4096;  // runs or cubes that a thread takes at a time

/// Calls visit(i) for all below `count`, many at once.
template <class Visit>
void for_all(std::size_t count, const Visit& visit) {
  using Range = tbb::blocked_range<std::uint32_t>;
  tbb::parallel_for(Range(0, static_cast<std::uint32_t>(count), kGrain), [&](const Range& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i) visit(i);
  });
}

std::vector<std::uint32_t> all_points(std::size_t count) {
  std::vector<std::uint32_t> points(count);
  std::iota(points.begin(), points.end(), 0u);
  return points;
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
  constexpr std::size_t kPoints = 16384;
  std::vector<std::vector<Run>> of_part((positions.size() + kPoints - 1) / kPoints);
  for_each_whole(of_part.size(), [&](std::size_t part) {
    std::vector<Run>& runs = of_part[part];
    const std::size_t end = std::min(positions.size(), (part + 1) * kPoints);
    for (auto i = static_cast<std::uint32_t>(part * kPoints); i < end; ++i) {
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
  const NeighborGrid cubes(coarse_cubes(step));
  const CellRows rows(cubes);
  check_loops_are_whole();
  std::vector<std::uint8_t> is_wanted(cubes.cells(), 0);
  for_all(cubes.cells(), [&](std::uint32_t cube) {
    const auto has_wanted = [&](std::uint32_t run) {
      const auto flags = wanted.subspan(runs_[run].begin, runs_[run].end - runs_[run].begin);
      return std::memchr(flags.data(), 1, flags.size()) != nullptr;
    };
    is_wanted[cube] = std::ranges::any_of(cubes.members(cube), has_wanted) ? 1 : 0;
  });
  std::vector<std::uint8_t> is_near(runs_.size(), 0);
  for_all(cubes.cells(), [&](std::uint32_t cube) {
    bool is_around_wanted = false;
    rows.for_each_around(cube, [&](std::uint32_t other) {
      is_around_wanted = is_around_wanted || is_wanted[other] != 0;
    });
    for (const std::uint32_t run : cubes.members(cube)) is_near[run] = is_around_wanted ? 1 : 0;
  });
  check_loops_are_whole();
  std::size_t found = 0;
  for (std::size_t run = 0; run < runs_.size(); ++run)
    if (is_near[run] != 0) found += runs_[run].end - runs_[run].begin;
  std::vector<std::uint32_t> points;
  points.reserve(found);
  for (std::size_t run = 0; run < runs_.size(); ++run)
    for (std::uint32_t i = runs_[run].begin; i < runs_[run].end && is_near[run] != 0; ++i)
      points.push_back(i);
  return points;
}

std::vector<LatticeCell> PointRuns::coarse_cubes(std::int64_t step) const {
  std::vector<LatticeCell> cubes(runs_.size());
  for_all(cubes.size(), [&](std::uint32_t run) { cubes[run] = coarse(runs_[run].cube, step); });
  return cubes;
}

}  // namespace orbweave
