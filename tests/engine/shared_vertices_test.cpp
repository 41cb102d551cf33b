#include "engine/holes/loops/shared_vertices.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <random>
#include <set>
#include <vector>

namespace orbweave {
namespace {

using Pair = std::array<std::uint64_t, 2>;

/// As the words say it: every pair of the loop's vertices that another loop visits both of.
std::vector<Pair> plain_pairs(const std::vector<BoundaryLoop>& loops, std::size_t number) {
  std::set<Pair> pairs;
  const std::vector<std::uint64_t>& own = loops[number].vertices;
  for (std::size_t other = 0; other < loops.size(); ++other) {
    const std::set<std::uint64_t> there(loops[other].vertices.begin(), loops[other].vertices.end());
    if (other == number) continue;
    for (const std::uint64_t a : own)
      for (const std::uint64_t b : own)
        if (a < b && there.contains(a) && there.contains(b)) pairs.insert({a, b});
  }
  return {pairs.begin(), pairs.end()};
}

/// The pairs of the groups that are made.
std::vector<Pair> pairs_of(const std::vector<Pair>& groups) {
  std::set<Pair> pairs;
  for (const auto& [a, group_of_a] : groups)
    for (const auto& [b, group_of_b] : groups)
      if (a < b && group_of_a == group_of_b) pairs.insert({a, b});
  return {pairs.begin(), pairs.end()};
}

}  // namespace

TEST_CASE("GroupsJoinTheVerticesThatLieTogetherOnAnotherLoop") {
  std::mt19937_64 random(7);
  for (int round = 0; round < 200; ++round) {
    std::vector<BoundaryLoop> loops(2 + random() % 6);
    for (BoundaryLoop& loop : loops)
      for (std::uint64_t i = 3 + random() % 8; i > 0; --i) loop.vertices.push_back(random() % 14);
    const SharedVertices shared(loops);
    for (std::uint32_t l = 0; l < loops.size(); ++l)
      REQUIRE(pairs_of(shared.groups_on(loops[l], l)) == plain_pairs(loops, l));
  }
}

TEST_CASE("LoopsThatMeetAtThousandsOfVerticesHoldOneEntryForEach") {
  // A chain of pieces joined tip to tip: the loops on its two sides meet at every tip.
  constexpr std::uint64_t kTips = 4000;
  std::vector<BoundaryLoop> loops(2);
  for (std::uint64_t tip = 0; tip < kTips; ++tip) {
    loops[0].vertices.insert(loops[0].vertices.end(), {3 * tip, 3 * tip + 1});
    loops[1].vertices.insert(loops[1].vertices.end(), {3 * tip, 3 * tip + 2});
  }
  const SharedVertices shared(loops);
  CHECK(shared.size() == 2 * kTips);
  CHECK(shared.groups_on(loops[0], 0).size() == kTips);
}

}  // namespace orbweave
