// Counting in memory ends with the cells of the streaming count.
#include "partition/cloud_counts.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "partition/count_grid.h"
#include "partition/strays.h"
#include "tests/support/clouds.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

using Row = std::array<double, 4>;

std::vector<Row> cells_of(const PointCounts& counts) {
  std::vector<Row> cells;
  counts.for_each([&](Vec3 corner, std::uint64_t count) {
    cells.push_back({corner.x, corner.y, corner.z, static_cast<double>(count)});
  });
  std::sort(cells.begin(), cells.end());
  return cells;
}

void check_same_counts(const std::vector<Vec3>& points) {
  CountGrid grid;
  constexpr std::size_t kBatch = 50'000;
  const std::span<const Vec3> all(points);
  for (std::size_t i = 0; i < all.size(); i += kBatch)
    grid.add(all.subspan(i, std::min(kBatch, all.size() - i)));
  const CloudCounts counts(points);
  CHECK(box_without_strays(counts).has_value() == box_without_strays(grid).has_value());
  grid.settle(root_cube(grid.bounds()).side);
  CHECK(counts.points() == grid.points());
  CHECK(counts.bounds() == grid.bounds());
  CHECK(counts.cell() == grid.cell());
  CHECK((cells_of(counts) == cells_of(grid)));
}

std::vector<Vec3> points_in_cube(std::size_t count, double side, Vec3 corner) {
  Random random(count);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(corner + side * Vec3{random.uniform(), random.uniform(), random.uniform()});
  return points;
}

}  // namespace

TEST_CASE("CountsInMemoryHaveTheCellsOfTheStreamingCount", "[slow]") {
  check_same_counts({Vec3{1.0, 2.0, 3.0}});
  check_same_counts(std::vector<Vec3>(1000, Vec3{-1.0, 2.0, 3.0}));
  for (const std::size_t count : {2, 100, 30'000, 262'144, 262'145, 700'000}) {
    check_same_counts(points_in_cube(count, 1.0, {}));
    check_same_counts(points_in_cube(count, 3e-3, {5e5, -4e6, -1e-3}));
  }
  check_same_counts(noisy_torus(400'000, 0.2, 1).cloud.positions);
}

TEST_CASE("CountsInMemoryFindTheStraysOfTheStreamingCount") {
  std::vector<Vec3> points = points_in_cube(300'000, 1.0, {});
  points.push_back({1e6, 0.0, 0.0});
  check_same_counts(points);
  points.resize(1000);
  points.push_back({1e6, 0.0, 0.0});
  check_same_counts(points);
}
