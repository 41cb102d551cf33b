// Cells of a map grid: which one a place lies in, and their names.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "io/meshes/map_grid.h"

namespace orbweave {
namespace {

std::string name_at(double size, double x, double y) {
  const MapGrid grid(size);
  return grid.name(grid.cell_of({x, y, 0.0}).value());
}

}  // namespace

TEST_CASE("CellsAreNamedByTheirLowerLeftCorner") {
  CHECK(name_at(500.0, 448'123.7, 4'511'000.0) == "448000_4511000");
  CHECK(name_at(500.0, 0.0, -0.001) == "0_-500");
  CHECK(name_at(0.25, 0.3, -0.3) == "0.25_-0.50");
  CHECK(name_at(0.1, 0.35, 7.0) == "0.3_7.0");  // 3 * 0.1 is 0.30000000000000004
  CHECK(name_at(1e-9, 1.5e-9, -1.0) == "0.000000001_-1.000000000");
  CHECK(name_at(1e12, -1.0, 3e12) == "-1000000000000_3000000000000");
}

TEST_CASE("ACellReachesFromItsEdgeToTheNext") {
  std::mt19937_64 random(7);
  for (const double size : {0.1, 0.3, 1.0 / 3.0, 7.0, 500.0}) {
    const MapGrid grid(size);
    for (int i = 0; i < 2000; ++i) {
      const auto index = static_cast<std::int32_t>(random() % 20'001) - 10'000;
      const double edge = grid.edge(index);
      const double below = std::nextafter(edge, -std::numeric_limits<double>::infinity());
      REQUIRE(grid.cell_of({edge, below, 0.0}) == MapCell{index, index - 1});
    }
  }
}

TEST_CASE("APlaceThatNoCellCanHoldHasNone") {
  const MapGrid grid(1e-3);
  CHECK(grid.cell_of({2e6, -2e6, 0.0}));
  CHECK_FALSE(grid.cell_of({3e6, 0.0, 0.0}));
  CHECK_FALSE(grid.cell_of({0.0, std::numeric_limits<double>::quiet_NaN(), 0.0}));
  CHECK_FALSE(grid.cell_of({std::numeric_limits<double>::infinity(), 0.0, 0.0}));
  CHECK_THROWS_AS(MapGrid(0.0), std::logic_error);
}

}  // namespace orbweave
