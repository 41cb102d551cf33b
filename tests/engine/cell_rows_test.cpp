#include "engine/geometry/cell_rows.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/clouds.h"

namespace orbweave {
namespace {

std::vector<Vec3> random_points(std::size_t count, Vec3 middle, double width, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Vec3> points(count);
  for (Vec3& p : points)
    p = middle + Vec3{width * random.uniform(), width * random.uniform(), width * random.uniform()};
  return points;
}

/// Every cell is compared with every other.
std::vector<std::uint32_t> cells_that_touch(const NeighborGrid& grid, std::uint32_t cell) {
  const LatticeCell own = grid.lattice_cell(cell);
  std::vector<std::uint32_t> found;
  for (std::uint32_t other = 0; other < grid.cells(); ++other) {
    const LatticeCell it = grid.lattice_cell(other);
    if (std::abs(it.x - own.x) <= 1 && std::abs(it.y - own.y) <= 1 && std::abs(it.z - own.z) <= 1)
      found.push_back(other);
  }
  return found;
}

void check_all_cells(const std::vector<Vec3>& points, double radius) {
  const NeighborGrid grid(points, radius);
  const CellRows rows(grid);
  std::vector<std::uint32_t> around, gathered, expected;
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell) {
    around.clear();
    rows.for_each_around(cell, [&](std::uint32_t near) { around.push_back(near); });
    REQUIRE(around == cells_that_touch(grid, cell));
    expected.clear();
    for (const std::uint32_t near : around)
      expected.insert(expected.end(), grid.members(near).begin(), grid.members(near).end());
    rows.gather(cell, gathered);
    REQUIRE(gathered == expected);
  }
}

}  // namespace

TEST_CASE("CellRowsFindTheCellsAroundEachCell") {
  check_all_cells(random_points(1500, {}, 1.0, 1), 0.08);
  check_all_cells(random_points(1500, {-0.5, -0.5, -0.5}, 1.0, 2), 0.2);
  check_all_cells(random_points(800, {4e5, 5.2e6, -80.0}, 10.0, 3), 0.7);
  check_all_cells(random_points(1, {}, 1.0, 4), 1.0);
}

// Two clumps are so far apart that cells of the box around both have no numbers of 64 bits.
TEST_CASE("CellRowsFindTheCellsAroundEachCellWhereTheLatticeIsTooWideForNumbers") {
  std::vector<Vec3> points = random_points(600, {}, 1.0, 5);
  const std::vector<Vec3> far = random_points(600, {4e5, 4e5, 4e5}, 1.0, 6);
  points.insert(points.end(), far.begin(), far.end());
  check_all_cells(points, 0.1);
}

TEST_CASE("CellRowsOfNoPointsAreEmpty") {
  const NeighborGrid grid(std::span<const Vec3>(), 1.0);
  const CellRows rows(grid);
  CHECK(grid.cells() == 0);
}

}  // namespace orbweave
