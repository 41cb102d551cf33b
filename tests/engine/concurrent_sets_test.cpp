// Sets that threads join at once are those of one thread.
#include "engine/geometry/concurrent_sets.h"

#include <oneapi/tbb/parallel_for.h>

#include <catch2/catch.hpp>
#include <random>

#include "engine/geometry/disjoint_sets.h"
#include "engine/holes/loops/mesh_surface.h"
#include "tests/support/meshes.h"

namespace orbweave {
namespace {

/// The smallest index of each index's set.
std::vector<std::uint32_t> roots_of(DisjointSets sets) {
  std::vector<std::uint32_t> roots;
  for (std::uint32_t x = 0; x < sets.size(); ++x) roots.push_back(sets.find(x));
  return roots;
}

}  // namespace

TEST_CASE("SetsJoinedByThreadsAreThoseOfOneThread") {
  constexpr std::uint32_t kCount = 100'000;
  for (const std::size_t unions : {1'000u, 60'000u, 300'000u}) {
    INFO(unions);
    std::mt19937 random(static_cast<unsigned>(unions));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs(unions);
    for (auto& [a, b] : pairs) {
      a = static_cast<std::uint32_t>(random() % kCount);
      b = static_cast<std::uint32_t>(random() % kCount);
    }
    DisjointSets one(kCount);
    ConcurrentSets several(kCount);
    for (const auto& [a, b] : pairs) one.unite(a, b);
    tbb::parallel_for(std::size_t{0}, pairs.size(),
                      [&](std::size_t i) { several.unite(pairs[i].first, pairs[i].second); });
    CHECK((several.take_roots() == roots_of(std::move(one))));
  }
}

TEST_CASE("PiecesOfAMeshHangTogetherOverEdgesAndNotOverVertices") {
  // Two triangles with an edge in common, one that touches them at a vertex, one apart; an edge of
  // three triangles joins none of them.
  TriangleMesh mesh;
  for (int i = 0; i < 14; ++i)
    mesh.vertices.positions.push_back({static_cast<double>(i), static_cast<double>(i % 3), 0.0});
  mesh.triangles = {{0, 1, 2},   {2, 1, 3},   {3, 4, 5},  {6, 7, 8},
                    {9, 10, 11}, {9, 10, 12}, {10, 9, 13}};
  const MeshComponents found = find_components(mesh, MeshSurface(mesh));
  CHECK((found.of_triangle == std::vector<std::uint32_t>{0, 0, 1, 2, 3, 4, 5}));
  REQUIRE(found.pieces.size() == 6);
  CHECK(found.pieces[0].triangles == 2);
  CHECK(found.pieces[0].box.max.x == 3.0);
  CHECK(found.pieces[1].box.min.x == 3.0);
}

TEST_CASE("AClosedMeshIsOnePieceAndTwoOfThemAreTwo") {
  const TriangleMesh torus = test::torus_mesh(2'000);
  TriangleMesh both = torus;
  const auto count = static_cast<std::uint32_t>(torus.vertices.size());
  both.vertices.append(torus.vertices);
  for (const Triangle& t : torus.triangles)
    both.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
  REQUIRE(find_components(torus, MeshSurface(torus)).pieces.size() == 1);
  const MeshComponents found = find_components(both, MeshSurface(both));
  REQUIRE(found.pieces.size() == 2);
  CHECK(found.pieces[0].triangles == torus.triangles.size());
  CHECK(found.pieces[1].triangles == torus.triangles.size());
  CHECK(found.of_triangle.back() == 1);
}

}  // namespace orbweave
