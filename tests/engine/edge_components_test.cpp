#include "engine/geometry/edge_components.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <vector>

namespace orbweave {
namespace {

/// A strip of triangles over vertices from `first` on.
void add_strip(std::uint32_t first, std::uint32_t triangles, std::vector<Triangle>& mesh) {
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const std::uint32_t a = first + i;
    mesh.push_back(i % 2 == 0 ? Triangle{a, a + 1, a + 2} : Triangle{a + 1, a, a + 2});
  }
}

/// Strips of 5, 900, 40 and 40 triangles, one after the other.
std::vector<Triangle> four_strips() {
  std::vector<Triangle> mesh;
  add_strip(0, 5, mesh);
  add_strip(100, 900, mesh);
  add_strip(2000, 40, mesh);
  add_strip(3000, 40, mesh);
  return mesh;
}

/// Ranks of all triangles when parts of the mesh are added; `part_of` ascends from 0.
std::vector<std::uint32_t> ranks_in_parts(const std::vector<Triangle>& mesh,
                                          const std::vector<std::size_t>& part_of) {
  std::vector<std::vector<Triangle>> parts(part_of.back() + 1);
  for (std::size_t t = 0; t < mesh.size(); ++t) parts[part_of[t]].push_back(mesh[t]);
  EdgeComponents components;
  for (const auto& part : parts)
    components.add(part, [](std::uint32_t vertex) { return std::uint64_t{vertex} << 33; });
  components.finish();
  std::vector<std::uint32_t> ranks;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::vector<std::uint32_t> of_part = components.ranks(p, parts[p]);
    ranks.insert(ranks.end(), of_part.begin(), of_part.end());
  }
  return ranks;
}

TEST_CASE("ComponentsAreRankedByTheirTrianglesThenByTheFirstOfThem") {
  const std::vector<Triangle> mesh = four_strips();
  EdgeComponents components;
  components.add(mesh, [](std::uint32_t vertex) { return std::uint64_t{vertex}; });
  components.finish();
  CHECK(components.triangles() == std::vector<std::uint64_t>{900, 40, 40, 5});
  const std::vector<std::uint32_t> ranks = components.ranks(0, mesh);
  CHECK(ranks.front() == 3);
  CHECK(ranks[5] == 0);
  CHECK(ranks[905] == 1);
  CHECK(ranks[945] == 2);
}

TEST_CASE("ComponentsAreTheSameInAnyCutOfTheMesh") {
  const std::vector<Triangle> mesh = four_strips();
  const std::vector<std::uint32_t> whole = ranks_in_parts(mesh, std::vector<std::size_t>(985, 0));
  std::mt19937_64 random(3);
  for (const std::uint64_t stride : {2, 7, 300}) {
    std::vector<std::size_t> part_of = {0};
    while (part_of.size() < mesh.size())
      part_of.push_back(part_of.back() + (random() % stride == 0 ? 1 : 0));
    CHECK(ranks_in_parts(mesh, part_of) == whole);
  }
}

TEST_CASE("TrianglesThatTouchAtAVertexAloneAreTwoComponents") {
  const std::vector<Triangle> mesh = {{0, 1, 2}, {2, 3, 4}, {1, 0, 5}};
  CHECK(ranks_in_parts(mesh, {0, 0, 0}) == std::vector<std::uint32_t>{0, 1, 0});
  CHECK(ranks_in_parts(mesh, {0, 1, 2}) == std::vector<std::uint32_t>{0, 1, 0});
}

TEST_CASE("PartsWithoutTrianglesHaveNoComponents") {
  EdgeComponents components;
  components.add({}, [](std::uint32_t vertex) { return std::uint64_t{vertex}; });
  components.finish();
  CHECK(components.triangles().empty());
  CHECK(components.ranks(0, {}).empty());
}

}  // namespace
}  // namespace orbweave
