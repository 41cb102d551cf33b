// Root cube, count grid and octree: every point has one chunk, whatever the cloud looks like.
#include "partition/octree.h"
#include "partition/count_grid.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "io/error.h"
#include "tests/partition/clouds.h"

namespace orbweave {
namespace {

struct NamedCloud {
  std::string name;
  std::vector<Vec3> points;
};

/// Clouds that have broken partitions before, or well might.
std::vector<NamedCloud> adversarial_clouds() {
  std::vector<NamedCloud> clouds = {
      {"shell around zero", test::shell(3000, {}, 1.0, 1)},
      {"UTM", test::shell(3000, {4.6e6, 5.2e5, 300.0}, 50.0, 2)},
      {"tiny", test::shell(3000, {1e-6, 0.0, 0.0}, 1e-6, 3)},
      {"huge", test::shell(3000, {}, 1e6, 4)},
      {"tiny scale", test::shell(3000, {}, 1e-200, 5)},
      {"huge scale", test::shell(3000, {}, 1e200, 6)},
      {"filled", test::filled_cube(3000, {-0.5, -0.5, -0.5}, 1.0, 7)},
      {"one point", {{3.0, -4.0, 5.0}}},
      {"one point at zero", {{0.0, 0.0, 0.0}}},
      {"one point far away", {{4.6e15, 1.0, -1e-9}}},
      {"equal points", std::vector<Vec3>(5000, Vec3{1.0, 2.0, 3.0})},
      {"two points", {{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}},
      {"neighbouring doubles", {{1.0, 1.0, 1.0}, {std::nextafter(1.0, 2.0), 1.0, 1.0}}},
      {"neighbouring doubles far away", {{1e15, 0.0, 0.0}, {std::nextafter(1e15, 2e15), 0.0, 0.0}}},
      {"far away along one axis only", {{1e15, 0.0, 0.0}, {1e15, 1e-9, 0.0}, {1e15, 0.0, -1e-9}}},
      {"exact powers of two", {{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}, {0.0, 0.5, -0.5}}},
      {"next to zero", {{-1.0, 0.0, 0.0}, {-1e-300, 1e-300, -0.0}, {1.0, 0.0, 0.0}}},
  };
  std::vector<Vec3> line, plane, outlier = test::shell(3000, {}, 1.0, 8);
  for (int i = 0; i < 2000; ++i) line.push_back({i * 0.1, 0.0, 7.0});
  for (int i = 0; i < 2000; ++i) plane.push_back({i % 50 * 0.25, i / 50 * 0.25, -3.0});
  outlier.push_back({5000.0, -3000.0, 1.0});
  clouds.push_back({"line", line});
  clouds.push_back({"grid in a plane", plane});
  clouds.push_back({"outlier", outlier});
  return clouds;
}

CountGrid counted(std::span<const Vec3> points, std::size_t batch, std::size_t limit_bytes) {
  CountGrid grid(limit_bytes);
  for (std::size_t first = 0; first < points.size(); first += batch)
    grid.add(points.subspan(first, std::min(batch, points.size() - first)));
  return grid;
}

Octree cut(std::span<const Vec3> points, std::uint64_t chunk_points,
           std::size_t limit_bytes = std::size_t{48} << 20) {
  CountGrid grid = counted(points, 1000, limit_bytes);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  return cut_octree(grid, root, chunk_points);
}

using CellCounts = std::map<std::array<double, 3>, std::uint64_t>;

CellCounts counts_of(const CountGrid& grid) {
  CellCounts counts;
  grid.for_each([&](Vec3 corner, std::uint64_t count) {
    REQUIRE(counts.emplace(std::array{corner.x, corner.y, corner.z}, count).second);
  });
  return counts;
}

CellCounts counts_by_hand(std::span<const Vec3> points, double cell) {
  CellCounts counts;
  for (const Vec3& p : points)
    ++counts[{std::floor(p.x / cell) * cell, std::floor(p.y / cell) * cell,
              std::floor(p.z / cell) * cell}];
  return counts;
}

bool same_chunks(const Octree& a, const Octree& b) {
  return a.root() == b.root() &&
         std::ranges::equal(a.chunks(), b.chunks(), [](const Chunk& x, const Chunk& y) {
           return x.code_begin == y.code_begin && x.code_end == y.code_end && x.depth == y.depth &&
                  x.box == y.box && x.points == y.points;
         });
}

}  // namespace

TEST_CASE("TheRootCubeHoldsTheCloudAndItsLatticesNest") {
  for (const auto& [name, points] : adversarial_clouds()) {
    INFO(name);
    Box bounds;
    for (const Vec3& p : points) bounds.extend(p);
    const RootCube root = root_cube(bounds);
    int exponent = 0;
    CHECK(std::frexp(root.side, &exponent) == 0.5);
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(root.origin[axis] <= bounds.min[axis]);
      CHECK(bounds.max[axis] - root.origin[axis] < root.side);
      CHECK(std::fmod(root.origin[axis], root.side / 256.0) == 0.0);
    }
    // As tight as powers of two allow; not finer than the coordinates themselves.
    double extent = bounds.largest_extent();
    for (int axis = 0; axis < 3; ++axis)
      extent = std::max(extent, 0x1p-52 * std::abs(bounds.max[axis]));
    if (bounds.largest_extent() > 0.0) CHECK(root.side <= 4.0 * extent);
  }
}

TEST_CASE("ACloudTooLargeForDoublesIsRefused") {
  const auto refuse = [](double coordinate) {
    Box bounds;
    bounds.extend(Vec3{-coordinate, 0.0, 0.0});
    bounds.extend(Vec3{coordinate, 0.0, 0.0});
    return root_cube(bounds);
  };
  CHECK_THROWS_AS(refuse(1.7e308), Error);
  CHECK_THROWS_AS(refuse(0.9e308), Error);
}

TEST_CASE("CountsAreExact") {
  // Small limits force the grid to coarsen again and again.
  const std::size_t limit = GENERATE(std::size_t{1}, std::size_t{200} << 10, std::size_t{48} << 20);
  const std::size_t batch = GENERATE(1, 100, 100'000);
  for (const auto& [name, points] : adversarial_clouds()) {
    INFO(name);
    CountGrid grid = counted(points, batch, limit);
    const RootCube root = root_cube(grid.bounds());
    grid.settle(root.side);
    Box bounds;
    for (const Vec3& p : points) bounds.extend(p);
    REQUIRE(grid.points() == points.size());
    REQUIRE(grid.bounds() == bounds);
    REQUIRE(counts_of(grid) == counts_by_hand(points, grid.cell()));
    REQUIRE(grid.cell() <= root.side / 256.0);
    REQUIRE(grid.cell() >= root.side / 0x1p21);
  }
}

TEST_CASE("TheGridDoesNotDependOnTheOrderOfPoints", "[costly]") {
  const std::size_t limit = GENERATE(std::size_t{1}, std::size_t{300} << 10, std::size_t{48} << 20);
  for (const auto& [name, points] : adversarial_clouds()) {
    INFO(name);
    const CountGrid grid = counted(points, 500, limit);
    for (std::uint64_t seed = 1; seed < 5; ++seed) {
      std::vector<Vec3> other = points;
      test::shuffle(other, seed);
      const CountGrid again = counted(other, 37 * seed, limit);
      REQUIRE(again.cell() == grid.cell());
      REQUIRE(counts_of(again) == counts_of(grid));
    }
  }
}

CountGrid in_parts(std::span<const Vec3> points, std::size_t parts, std::size_t limit) {
  std::vector<CountGrid::Part> counts;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::size_t first = points.size() * part / parts;
    const std::size_t last = points.size() * (part + 1) / parts;
    counts.push_back(counted(points.subspan(first, last - first), 1000, limit).part());
  }
  return CountGrid::of_parts(counts, limit);
}

TEST_CASE("GridsOfPartsMakeTheGridOfTheWhole", "[costly]") {
  const std::size_t limit = GENERATE(std::size_t{300} << 10, std::size_t{16} << 20);
  auto clouds = adversarial_clouds();
  std::vector<Vec3> large = test::shell(300'000, {5.0, 0.0, -2.0}, 1.0, 4);
  large.insert(large.end(), 300'000, Vec3{0.125, -7.0, 3.0});  // a part of one point alone
  clouds.push_back({"large", large});
  clouds.push_back({"all equal", std::vector<Vec3>(10'000, Vec3{1.0, 2.0, 3.0})});
  for (const auto& [name, points] : clouds) {
    INFO(name);
    const CountGrid whole = counted(points, 1000, limit);
    for (const std::size_t parts : {1, 2, 5, 8}) {
      const CountGrid together = in_parts(points, parts, limit);
      CHECK(together.points() == whole.points());
      CHECK(together.bounds() == whole.bounds());
      CHECK(together.cell() == whole.cell());
      CHECK(counts_of(together) == counts_of(whole));
    }
  }
}

TEST_CASE("GridsMergedPairwiseInAnyOrderMakeTheGridOfTheWhole", "[costly]") {
  constexpr std::size_t kLimit = std::size_t{300} << 10;
  auto clouds = adversarial_clouds();
  std::vector<Vec3> large = test::shell(300'000, {5.0, 0.0, -2.0}, 1.0, 4);
  large.insert(large.end(), 10'000, Vec3{0.125, -7.0, 3.0});
  clouds.push_back({"large", large});
  for (const auto& [name, points] : clouds) {
    INFO(name);
    const CountGrid whole = counted(points, 1000, kLimit);
    for (const std::uint64_t seed : {1, 2, 3}) {
      constexpr std::size_t kShares = 11;
      std::vector<CountGrid::Part> shares;
      for (std::size_t share = 0; share < kShares; ++share) {
        const std::size_t first = points.size() * share / kShares;
        const std::size_t last = points.size() * (share + 1) / kShares;
        shares.push_back(
            counted(std::span(points).subspan(first, last - first), 1000, kLimit).part());
      }
      std::mt19937_64 random(seed);
      while (shares.size() > 1) {
        std::swap(shares[random() % (shares.size() - 1)], shares[shares.size() - 2]);
        const CountGrid pair = CountGrid::of_parts(std::span(shares).last(2), kLimit);
        shares.resize(shares.size() - 2);
        shares.insert(shares.begin(), pair.part());
      }
      const CountGrid merged = CountGrid::of_parts(shares, kLimit);
      CHECK(merged.points() == whole.points());
      CHECK(merged.cell() == whole.cell());
      CHECK(counts_of(merged) == counts_of(whole));
    }
  }
}

TEST_CASE("TheGridKeepsToItsMemory") {
  constexpr std::size_t kLimit = std::size_t{16} << 20;
  CountGrid grid(kLimit);
  // Grows outward from tiny to large: worst for a grid that began fine.
  double reach = 1e-9;
  for (int batch = 0; batch < 60; ++batch, reach *= 1.5) {
    grid.add(test::shell(2000, {}, reach, static_cast<std::uint64_t>(batch)));
    CHECK(grid.memory_bytes() <= kLimit + 20'000);
  }
  CHECK(grid.points() == 120'000);
  // Dense space is where 256 cells a side may cost more than the limit.
  CountGrid dense(kLimit);
  dense.add(test::filled_cube(200'000, {}, 1.0, 1));
  CHECK(dense.memory_bytes() < (std::size_t{80} << 20));
  CHECK(dense.cell() <= root_cube(dense.bounds()).side / 256.0);
}

TEST_CASE("MillionsOfEqualPointsAreCounted", "[costly]") {
  CountGrid grid;
  const std::vector<Vec3> equal(1'000'000, Vec3{0.1, 0.2, 0.3});
  for (int i = 0; i < 5; ++i) grid.add(equal);
  const std::vector<Vec3> other = {{0.4, 0.2, 0.3}};
  SECTION("alone") { CHECK(counts_of(grid).begin()->second == 5'000'000); }
  SECTION("before another") {
    grid.add(other);
    CHECK(counts_of(grid).size() == 2);
    CHECK(counts_of(grid).begin()->second == 5'000'000);
    CHECK(grid.points() == 5'000'001);
  }
  SECTION("after another") {
    CountGrid late;
    late.add(other);
    for (int i = 0; i < 5; ++i) late.add(equal);
    CHECK(late.cell() == (grid.add(other), grid.cell()));
    CHECK(counts_of(late) == counts_of(grid));
  }
}

TEST_CASE("EveryPointHasExactlyOneChunk") {
  const std::uint64_t chunk_points = GENERATE(1, 20, 500, 1'000'000);
  for (const auto& [name, points] : adversarial_clouds()) {
    INFO(name);
    const Octree octree = cut(points, chunk_points);
    std::vector<std::uint64_t> owned(octree.chunks().size());
    for (const Vec3& p : points) {
      const ChunkId chunk = octree.chunk_of(p);
      const std::uint64_t code = morton_code(p, octree.root());
      REQUIRE(octree.chunks()[chunk].code_begin <= code);
      REQUIRE(code < octree.chunks()[chunk].code_end);
      REQUIRE(octree.chunks()[chunk].box.contains(p));
      REQUIRE(chunk == octree.chunk_of_code(code));
      ++owned[chunk];
    }
    for (std::size_t i = 0; i < owned.size(); ++i) {
      REQUIRE(owned[i] == octree.chunks()[i].points);
      REQUIRE(owned[i] > 0);
      if (i > 0) REQUIRE(octree.chunks()[i - 1].code_end <= octree.chunks()[i].code_begin);
    }
  }
}

TEST_CASE("ChunksKeepToTheirPointsAndAreNoSmallerThanNeeded") {
  const std::vector<Vec3> points = test::shell(50'000, {7.0, 7.0, 7.0}, 1.0, 4);
  const std::uint64_t chunk_points = GENERATE(200, 1000, 20'000);
  const Octree octree = cut(points, chunk_points);
  std::map<std::uint64_t, std::uint64_t> parents;
  for (const Chunk& chunk : octree.chunks()) {
    CHECK(chunk.points <= chunk_points);
    REQUIRE(chunk.depth > 0);
    const int shift = 3 * (kMortonDepth - chunk.depth + 1);
    for (const Vec3& p : points)
      parents[chunk.code_begin >> shift << shift] +=
          morton_code(p, octree.root()) >> shift == chunk.code_begin >> shift;
    if (octree.chunks().size() > 40) break;  // one will do where there are many
  }
  for (const auto& [code, count] : parents) CHECK(count > chunk_points);
}

TEST_CASE("CoarserChunksAreThoseOfACoarserCutAndHoldWholeChunks") {
  for (const NamedCloud& cloud : adversarial_clouds()) {
    INFO(cloud.name);
    const Octree fine = cut(cloud.points, 60);
    for (const std::uint64_t limit :
         {std::uint64_t{60}, std::uint64_t{500}, std::uint64_t{1} << 40}) {
      const Octree coarse = coarsened(fine, limit);
      std::uint64_t points = 0;
      std::size_t next = 0;
      for (const Chunk& chunk : coarse.chunks()) {
        std::uint64_t inside = 0;
        const std::size_t first = next;
        for (; next < fine.chunks().size() && fine.chunks()[next].code_end <= chunk.code_end;
             ++next)
          inside += fine.chunks()[next].points;
        CHECK(inside == chunk.points);
        CHECK((chunk.points <= limit || next - first == 1));
        points += inside;
      }
      CHECK(points == cloud.points.size());
      for (const Vec3& p : cloud.points) {
        const Chunk& chunk = coarse.chunks()[coarse.chunk_of(p)];
        const Chunk& part = fine.chunks()[fine.chunk_of(p)];
        REQUIRE((chunk.code_begin <= part.code_begin && part.code_end <= chunk.code_end));
      }
    }
    CHECK(coarsened(fine, std::uint64_t{1} << 40).chunks().size() == 1);
  }
}

TEST_CASE("ManyPointsInOneCellStayTogether") {
  std::vector<Vec3> points(3000, Vec3{0.25, 0.25, 0.25});
  points.push_back({1.0, 1.0, 1.0});
  const Octree octree = cut(points, 10);
  REQUIRE(octree.chunks().size() == 2);
  CHECK(octree.chunks()[0].points == 3000);
}

TEST_CASE("TheCutDoesNotDependOnTheOrderOfPoints") {
  const std::size_t limit = GENERATE(std::size_t{100} << 10, std::size_t{48} << 20);
  for (const auto& [name, points] : adversarial_clouds()) {
    INFO(name);
    const Octree octree = cut(points, 100, limit);
    std::vector<Vec3> other = points;
    test::shuffle(other, 3);
    REQUIRE(same_chunks(cut(other, 100, limit), octree));
    REQUIRE(
        same_chunks(cut(std::vector<Vec3>(points.rbegin(), points.rend()), 100, limit), octree));
  }
}

TEST_CASE("ChunksAndPointsComeInTheSameOrder") {
  PointCloud cloud;
  cloud.positions = test::shell(5000, {-3.0, 1.0, 0.0}, 2.0, 6);
  const Octree octree = cut(cloud.positions, 50);
  sort_canonically(cloud, octree.root());
  ChunkId last = 0;
  for (const Vec3& p : cloud.positions) {
    REQUIRE(octree.chunk_of(p) >= last);
    last = octree.chunk_of(p);
  }
  CHECK(last + 1 == octree.chunks().size());
}

TEST_CASE("APointWhereNoneWasCountedIsBadInput") {
  const Octree octree = cut(std::vector<Vec3>{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}}, 1);
  try {
    octree.chunk_of({1.5, 0.1, 0.9});
    FAIL("a chunk was found");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kBadInput);
  }
  CHECK_THROWS_AS(Octree().chunk_of_code(0), Error);
}

TEST_CASE("NeighborsEqualBruteForce") {
  const double halo = GENERATE(0.0, 1e-3, 0.05, 0.4, 10.0);
  for (const auto& [name, points] : adversarial_clouds()) {
    INFO(name);
    const Octree octree = cut(points, 30);
    const double width = halo * octree.root().side;
    for (ChunkId self = 0; self < octree.chunks().size(); self += 3) {
      std::vector<ChunkId> expected;
      const Box reach = octree.chunks()[self].box.grown(width);
      for (ChunkId other = 0; other < octree.chunks().size(); ++other)
        if (other != self && reach.intersects(octree.chunks()[other].box))
          expected.push_back(other);
      REQUIRE(octree.neighbors(self, width) == expected);
    }
  }
}

TEST_CASE("ManyChunksHaveTheirNeighborsQuickly") {
  const Octree octree = cut(test::shell(200'000, {}, 1.0, 2), 20);
  REQUIRE(octree.chunks().size() > 10'000);
  std::size_t found = 0;
  for (ChunkId self = 0; self < octree.chunks().size(); ++self)
    found += octree.neighbors(self, 1e-3).size();
  CHECK(found > 4 * octree.chunks().size());
}

}  // namespace orbweave
