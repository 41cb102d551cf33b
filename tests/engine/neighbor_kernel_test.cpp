// Searches find the same points and distances at every vector width.
#include "engine/geometry/neighbor_kernel.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>
#include <vector>

#include "io/vec3.h"
#include "tests/support/clouds.h"
#include "tests/support/vector_widths.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kBlocks = 5, kPoints = kBlocks * kPointsPerBlock;

/// Blocks of points, every second one of which is looked at.
struct Blocks {
  std::vector<double> x, y, z, bounds[6], parts[6];
  std::vector<std::uint32_t> block;

  explicit Blocks(test::Random& random) : x(kPoints), y(kPoints), z(kPoints) {
    // Lattice coordinates: many distances are equal, to one another and to the limit.
    for (std::vector<double>* axis : {&x, &y, &z})
      for (double& value : *axis) value = std::floor(6.0 * random.uniform()) / 4.0;
    for (std::uint32_t b = 0; b < kBlocks; b += 2) {
      block.push_back(b);
      bound(b * kPointsPerBlock, kPointsPerBlock, bounds);
    }
    for (auto& column : bounds) column.resize(column.size() + kMostLanes);
    constexpr std::uint32_t kPart = kPointsPerBlock / kPartsPerBlock;
    for (std::uint32_t first = 0; first < kPoints; first += kPart) bound(first, kPart, parts);
    for (auto& column : parts) column.resize(column.size() + kMostLanes);
  }
  void bound(std::uint32_t first, std::uint32_t count, std::vector<double> (&columns)[6]) {
    int column = 0;
    for (const std::vector<double>* axis : {&x, &y, &z}) {
      const auto begin = axis->begin() + first, end = begin + count;
      columns[column].push_back(*std::min_element(begin, end));
      columns[column++ + 3].push_back(*std::max_element(begin, end));
    }
  }
  PositionColumns positions() const {
    PositionColumns result{x.data(), y.data(), z.data(), {}};
    for (int column = 0; column < 6; ++column) result.bounds[column] = parts[column].data();
    return result;
  }
  BlockColumns columns() const {
    BlockColumns result;
    for (int column = 0; column < 6; ++column) result.bounds[column] = bounds[column].data();
    result.block = block.data();
    result.count = static_cast<std::uint32_t>(block.size());
    return result;
  }
  double squared(std::uint32_t i, Vec3 place) const {
    return squared_norm(Vec3{x[i], y[i], z[i]} - place);
  }
};

using Found = std::vector<std::pair<double, std::uint32_t>>;

/// What is found, with room for the work of a selection.
struct Room {
  std::vector<double> squared = std::vector<double>(2 * (kPoints + kMostLanes));
  std::vector<std::uint32_t> index = std::vector<std::uint32_t>(kPoints + kMostLanes);
  FoundColumns columns() { return {squared.data(), index.data()}; }
  Found first(std::uint32_t count) const {
    Found found;
    for (std::uint32_t i = 0; i < count; ++i) found.emplace_back(squared[i], index[i]);
    return found;
  }
};

}  // namespace

TEST_CASE("EveryFormOfASearchFindsThePointsWithinTheLimit") {
  test::Random random(17);
  const Vec3 place{0.5, 0.75, 0.25};
  for (int trial = 0; trial < 500; ++trial) {
    const Blocks blocks(random);
    const double limit = trial % 5 == 0 ? std::numeric_limits<double>::infinity()
                                        : std::floor(40.0 * random.uniform()) / 16.0;
    const auto self = static_cast<std::uint32_t>(random.below(kPoints));
    Found expected;
    for (const std::uint32_t b : blocks.block) {
      for (std::uint32_t i = b * kPointsPerBlock; i < (b + 1) * kPointsPerBlock; ++i)
        if (i != self && blocks.squared(i, place) <= limit)
          expected.emplace_back(blocks.squared(i, place), i);
    }
    for (const VectorWidth width : test::supported_widths()) {
      const NeighborKernel kernel = neighbor_kernel(width);
      Room room;
      const std::uint32_t count = kernel.gather(blocks.positions(), blocks.columns(), &place.x,
                                                self, limit, room.columns());
      REQUIRE(room.first(count) == expected);
    }
  }
}

TEST_CASE("EveryFormOfASearchSelectsTheNearestAndOfEquallyDistantOnesTheFirst") {
  test::Random random(19);
  for (int trial = 0; trial < 3000; ++trial) {
    const auto count = static_cast<std::uint32_t>(2 + random.below(kPoints - 1));
    const auto wanted = static_cast<std::uint32_t>(1 + random.below(count - 1));
    // From all alike over a few values to all different, some of them very unevenly spread.
    const double values = std::ldexp(1.0, trial % 12);
    std::vector<double> squared;
    for (std::uint32_t i = 0; i < count; ++i) {
      const double value = std::floor(values * random.uniform());
      squared.push_back(trial % 3 == 0 ? std::pow(value, 9.0) : value / values);
    }
    Found expected;
    for (std::uint32_t i = 0; i < count; ++i) expected.emplace_back(squared[i], 3 * i);
    std::sort(expected.begin(), expected.end());
    expected.resize(wanted);
    const double last = expected.back().first;
    std::sort(expected.begin(), expected.end(),
              [](const auto& a, const auto& b) { return a.second < b.second; });
    for (const VectorWidth width : test::supported_widths()) {
      const NeighborKernel kernel = neighbor_kernel(width);
      Room from, to;
      std::copy(squared.begin(), squared.end(), from.squared.begin());
      for (std::uint32_t i = 0; i < count; ++i) from.index[i] = 3 * i;
      const double limit = kernel.select(from.columns(), count, wanted, to.columns());
      REQUIRE(to.first(wanted) == expected);
      REQUIRE(limit >= last);
    }
  }
}

TEST_CASE("EveryFormOfASearchFindsTheBoxesWithinTheLimitOfABox") {
  test::Random random(23);
  const auto coordinate = [&] { return std::floor(12.0 * random.uniform()) / 4.0; };
  const auto interval = [&] {
    const double a = coordinate(), b = coordinate();
    return std::pair(std::min(a, b), std::max(a, b));
  };
  constexpr std::size_t kFirst = 3, kBoxes = kFirst + kBoxesAtOnce;
  for (int trial = 0; trial < 500; ++trial) {
    std::vector<double> columns[6];
    Vec3 low, high;
    for (int axis = 0; axis < 3; ++axis) {
      std::tie(low[axis], high[axis]) = interval();
      for (std::size_t box = 0; box < kBoxes; ++box) {
        const auto [from, to] = interval();
        columns[axis].push_back(from);
        columns[axis + 3].push_back(to);
      }
    }
    const double limit = std::floor(16.0 * random.uniform()) / 16.0;
    unsigned expected = 0;
    for (std::size_t box = kFirst; box < kBoxes; ++box) {
      Vec3 apart;
      for (int axis = 0; axis < 3; ++axis)
        apart[axis] =
            std::max({columns[axis][box] - high[axis], low[axis] - columns[axis + 3][box], 0.0});
      if (squared_norm(apart) <= limit) expected |= 1u << (box - kFirst);
    }
    const double* bounds[6];
    for (int column = 0; column < 6; ++column) bounds[column] = columns[column].data();
    for (const VectorWidth width : test::supported_widths())
      REQUIRE(neighbor_kernel(width).near_boxes(bounds, kFirst, &low.x, &high.x, limit) ==
              expected);
  }
}

}  // namespace orbweave
