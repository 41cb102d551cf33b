// The canonical order depends on the points and their bounds, and on nothing else.
#include "partition/canonical_order.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "partition/radix_sort.h"
#include "tests/partition/clouds.h"

namespace orbweave {
namespace {

using test::dressed;
using test::same_bits;
using test::shuffled;
using test::unit;

/// Interleaving as one would explain it.
std::uint64_t interleave_bit_by_bit(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < kMortonDepth; ++bit) {
    code |= (std::uint64_t{x >> bit & 1}) << (3 * bit);
    code |= (std::uint64_t{y >> bit & 1}) << (3 * bit + 1);
    code |= (std::uint64_t{z >> bit & 1}) << (3 * bit + 2);
  }
  return code;
}

/// A cloud in which everything that can tie ties: few coordinates, normals and attributes.
PointCloud ties(std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  PointCloud cloud;
  cloud.schema = {
      true, ScalarType::kFloat64, ScalarType::kFloat32, {{"label", ScalarType::kUint8}}};
  const auto coordinate = [&] {
    constexpr double kValues[] = {0.0, -0.0, 1e-300, -1e-300, 0.5, 1.0, 0x1.0p-30};
    return kValues[random() % 7];
  };
  for (std::size_t i = 0; i < count; ++i) {
    cloud.positions.push_back({coordinate(), coordinate(), coordinate()});
    cloud.normals.push_back({random() % 2 == 0 ? 0.0 : -0.0, 0.0, random() % 2 == 0 ? 1.0 : -1.0});
    cloud.attributes.push_back(static_cast<std::byte>(random() % 2));
  }
  return cloud;
}

}  // namespace

TEST_CASE("InterleavingPutsXLowest") {
  CHECK(interleave(1, 0, 0) == 1);
  CHECK(interleave(0, 1, 0) == 2);
  CHECK(interleave(0, 0, 1) == 4);
  CHECK(interleave(0x1fffff, 0x1fffff, 0x1fffff) == (std::uint64_t{1} << 63) - 1);
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto x = static_cast<std::uint32_t>(random() & 0x1fffff);
    const auto y = static_cast<std::uint32_t>(random() & 0x1fffff);
    const auto z = static_cast<std::uint32_t>(random() & 0x1fffff);
    const std::uint64_t code = interleave(x, y, z);
    REQUIRE(code == interleave_bit_by_bit(x, y, z));
    REQUIRE(deinterleave(code, 0) == x);
    REQUIRE(deinterleave(code, 1) == y);
    REQUIRE(deinterleave(code, 2) == z);
  }
}

TEST_CASE("CodesAreExactNextToEveryCellBorder") {
  // Around zero, where p - origin rounds; at UTM coordinates; tiny; huge.
  const double side = GENERATE(1.0, 128.0, 0x1p-20, 0x1p40);
  const double origin = GENERATE(0.0, -0.25, -1.0, -1.0 + 1.0 / 256, 1.5, 36000.0, -36000.0) * side;
  const RootCube root{{origin, origin, origin}, side};
  const MortonFrame frame(root);
  const double cell = root.cell(kMortonDepth);
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 2000; ++trial) {
    const std::uint32_t k = trial < 10 ? trial : static_cast<std::uint32_t>(random() & 0x1fffff);
    const double border = origin + k * cell;
    REQUIRE(frame.coordinate(border, 0) == k);
    const double below = std::nextafter(border, -INFINITY);
    REQUIRE(frame.coordinate(below, 1) == (k == 0 ? 0 : k - 1));
  }
  if (origin <= 0.0 && origin + side > 0.0) {
    const std::uint32_t zero = frame.coordinate(0.0, 0);
    CHECK(frame.coordinate(-0.0, 0) == zero);
    CHECK(frame.coordinate(1e-300, 0) == zero);
    if (zero > 0) CHECK(frame.coordinate(-1e-300, 0) == zero - 1);
  }
}

TEST_CASE("PointsOutsideAreClamped") {
  const RootCube root{{-1.0, -1.0, -1.0}, 2.0};
  CHECK(morton_code({-5.0, -1e300, -1.0}, root) == 0);
  CHECK(morton_code({5.0, 1.0, 1e300}, root) == (std::uint64_t{1} << 63) - 1);
}

TEST_CASE("CanonicalOrderIsIndependentOfInputOrder") {
  const std::size_t count = GENERATE(1, 2, 17, 300, 5000);
  const bool tied = GENERATE(false, true);
  PointCloud cloud = tied ? ties(count, count)
                          : dressed(test::shell(count, {4.6e6, 5.2e5, 300.0}, 50.0, count), 7);
  const RootCube root = root_cube(cloud.bounds());
  PointCloud reference = cloud;
  const std::uint64_t merged = sort_canonically(reference, root);
  CHECK(reference.size() + merged == count);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    PointCloud other = shuffled(cloud, seed);
    REQUIRE(sort_canonically(other, root) == merged);
    REQUIRE(same_bits(other, reference));
  }
}

TEST_CASE("SortedCloudsAscendStrictly") {
  PointCloud cloud = GENERATE(ties(4000, 1), dressed(test::filled_cube(20'000, {}, 1.0, 4), 1));
  const RootCube root = root_cube(cloud.bounds());
  sort_canonically(cloud, root);
  for (std::size_t i = 1; i < cloud.size(); ++i) {
    REQUIRE(canonically_before(cloud.positions[i - 1], cloud.positions[i], root));
    REQUIRE_FALSE(canonically_before(cloud.positions[i], cloud.positions[i - 1], root));
  }
  PointCloud again = cloud;
  CHECK(sort_canonically(again, root) == 0);
  CHECK(same_bits(again, cloud));
}

TEST_CASE("PointsKeepTheirNormalsAndAttributes") {
  const PointCloud cloud = dressed(test::shell(10'000, {}, 1.0, 3), 5);
  PointCloud sorted = shuffled(cloud, 9);
  sort_canonically(sorted, root_cube(cloud.bounds()));
  const auto less = [](Vec3 a, Vec3 b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::map<Vec3, std::size_t, decltype(less)> where(less);
  for (std::size_t i = 0; i < cloud.size(); ++i) where[cloud.positions[i]] = i;
  REQUIRE(sorted.size() == cloud.size());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const std::size_t original = where.at(sorted.positions[i]);
    REQUIRE(sorted.normals[i] == cloud.normals[original]);
    REQUIRE(std::ranges::equal(sorted.attribute_row(i), cloud.attribute_row(original)));
  }
}

TEST_CASE("OfDuplicatesTheOneFirstInByteOrderStays") {
  PointCloud cloud;
  cloud.schema = {
      true, ScalarType::kFloat64, ScalarType::kFloat32, {{"label", ScalarType::kUint8}}};
  const auto push = [&](Vec3 p, Vec3 n, int label) {
    cloud.positions.push_back(p);
    cloud.normals.push_back(n);
    cloud.attributes.push_back(static_cast<std::byte>(label));
  };
  push({1.0, 0.0, 2.0}, {0.0, 0.0, 1.0}, 200);
  push({1.0, -0.0, 2.0}, {0.0, 0.0, 1.0}, 7);
  push({1.0, 0.0, 2.0}, {0.0, 0.0, 1.0}, 9);
  push({3.0, 0.0, 2.0}, {0.0, 0.0, 1.0}, 1);
  CHECK(sort_canonically(cloud, root_cube(cloud.bounds())) == 2);
  REQUIRE(cloud.size() == 2);
  CHECK(cloud.attributes[0] == std::byte{7});
  CHECK(std::signbit(cloud.positions[0].y));
  CHECK(cloud.positions[1].x == 3.0);
}

TEST_CASE("SortingCutPiecesEqualsSortingTheWhole") {
  // What makes the output independent of the partition: cut by code, sort each, join.
  const PointCloud cloud = dressed(test::shell(20'000, {1.0, -2.0, 0.5}, 3.0, 8), 5);
  const RootCube root = root_cube(cloud.bounds());
  PointCloud whole = cloud;
  sort_canonically(whole, root);
  const int depth = GENERATE(1, 2, 4);
  std::map<std::uint64_t, PointCloud> pieces;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    PointCloud& piece = pieces[morton_code(cloud.positions[i], root) >> 3 * (kMortonDepth - depth)];
    piece.schema = cloud.schema;
    piece.append(cloud, i);
  }
  PointCloud joined;
  joined.schema = cloud.schema;
  for (auto& [code, piece] : pieces) {
    sort_canonically(piece, root);
    joined.append(piece);
  }
  CHECK(same_bits(joined, whole));
}

TEST_CASE("CloudsWithoutNormalsOrAttributesAreSorted") {
  PointCloud cloud;
  cloud.positions = test::shell(3000, {}, 1.0, 2);
  cloud.positions.push_back(cloud.positions.front());
  const RootCube root = root_cube(cloud.bounds());
  CHECK(sort_canonically(cloud, root) == 1);
  CHECK(cloud.size() == 3000);
  PointCloud empty;
  CHECK(sort_canonically(empty, root) == 0);
}

TEST_CASE("RadixSortEqualsStableSort") {
  std::mt19937_64 random(3);
  const std::size_t count = GENERATE(0, 1, 2, 48, 49, 1000, 60'000, 300'000);
  // Bits that vary: none, low, high, all, few distinct, one outlier.
  const int kind = GENERATE(0, 1, 2, 3, 4, 5);
  std::vector<KeyIndex> items;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t r = random();
    const std::uint64_t keys[] = {42, r & 0xfff,   r & ~std::uint64_t{0xffffffff},
                                  r,  r % 5 << 40, i == 7 ? ~std::uint64_t{0} : r >> 30};
    items.push_back({keys[kind], i});
  }
  std::vector<KeyIndex> expected = items;
  std::stable_sort(expected.begin(), expected.end(),
                   [](const KeyIndex& a, const KeyIndex& b) { return a.key < b.key; });
  radix_sort(items);
  const bool equal = std::equal(
      items.begin(), items.end(), expected.begin(), expected.end(),
      [](const KeyIndex& a, const KeyIndex& b) { return a.key == b.key && a.index == b.index; });
  CHECK(equal);
}

TEST_CASE("RunsOfEqualKeysAreFoundWhereverTheyLie") {
  std::mt19937_64 random(5);
  const std::size_t count = GENERATE(0, 1, 131'072, 131'073, 400'000);
  const std::uint64_t longest = GENERATE(1, 3, 200'000);
  std::vector<KeyIndex> items;
  std::vector<std::uint32_t> expected;
  for (std::uint64_t key = 0; items.size() < count; ++key) {
    expected.push_back(static_cast<std::uint32_t>(items.size()));
    for (std::uint64_t i = random() % longest; items.size() < count; --i) {
      items.push_back({key, static_cast<std::uint32_t>(items.size())});
      if (i == 0) break;
    }
  }
  expected.push_back(static_cast<std::uint32_t>(count));
  CHECK(run_begins(items) == expected);
}

}  // namespace orbweave
