// Scans of a block find the same points and distances at every vector width.
#include "engine/geometry/block_scan.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/clouds.h"

namespace orbweave {

TEST_CASE("EveryFormOfABlockScanFindsTheSame") {
  test::Random random(17);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> x(kPointsPerBlock), y(kPointsPerBlock), z(kPointsPerBlock);
    // Lattice coordinates: many distances are equal, to one another and to the limit.
    for (std::vector<double>* axis : {&x, &y, &z})
      for (double& value : *axis) value = std::floor(6.0 * random.uniform()) / 4.0;
    const double limit = trial % 5 == 0 ? std::numeric_limits<double>::infinity()
                                        : std::floor(40.0 * random.uniform()) / 16.0;
    NearInBlock expected, found;
    scan_block_generic(x.data(), y.data(), z.data(), 0.5, 0.75, 0.25, limit, expected);
    block_scan()(x.data(), y.data(), z.data(), 0.5, 0.75, 0.25, limit, found);
    REQUIRE(found.count == expected.count);
    REQUIRE(std::equal(expected.squared, expected.squared + kPointsPerBlock, found.squared));
    REQUIRE(std::equal(expected.listed, expected.listed + expected.count, found.listed));
    for (std::uint32_t l = 0; l < found.count; ++l)
      REQUIRE(found.squared[found.listed[l]] <= limit);
  }
}

}  // namespace orbweave
