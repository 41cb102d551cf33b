#include "engine/holes/loops/islands.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>
#include <vector>

#include "io/error.h"

namespace orbweave {
namespace {

struct Loops {
  std::vector<BoundaryVertex> vertices;
  std::vector<BoundaryLoop> loops;  // the hole, then its islands

  std::vector<std::uint32_t> islands() const {
    std::vector<std::uint32_t> islands;
    for (std::uint32_t l = 1; l < loops.size(); ++l) islands.push_back(l);
    return islands;
  }
  void begin_loop() { loops.emplace_back().components = {loops.size()}; }
  void add(Vec3 position) {
    loops.back().vertices.push_back(vertices.size());
    vertices.push_back({vertices.size(), position, {0.0, 0.0, 1.0}});
  }
  void add_circle(Vec3 center, double radius, int corners) {
    begin_loop();
    for (int i = 0; i < corners; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / corners;
      add(center + radius * Vec3{std::cos(angle), std::sin(angle), 0.0});
    }
  }
};

/// Every corner that is joined is compared with every corner that is not, again for each island.
std::vector<std::uint64_t> plainly_joined(const Loops& all) {
  std::vector<std::uint64_t> joined = all.loops[0].vertices;
  std::vector<std::uint32_t> left = all.islands();
  while (!left.empty()) {
    // Length, island, corner of it, corner of the joined loop.
    std::tuple best{std::numeric_limits<double>::infinity(), 0U, 0U, 0U};
    for (std::uint32_t i = 0; i < left.size(); ++i) {
      const std::vector<std::uint64_t>& island = all.loops[left[i]].vertices;
      for (std::uint32_t to = 0; to < island.size(); ++to)
        for (std::uint32_t from = 0; from < joined.size(); ++from)
          best = std::min(best, std::tuple{squared_norm(all.vertices[island[to]].position -
                                                        all.vertices[joined[from]].position),
                                           i, to, from});
    }
    const auto [length, i, to, from] = best;
    std::vector<std::uint64_t> way = all.loops[left[i]].vertices;
    std::rotate(way.begin(), way.begin() + to, way.end());
    way.insert(way.end(), {way.front(), joined[from]});
    joined.insert(joined.begin() + from + 1, way.begin(), way.end());
    left.erase(left.begin() + i);
  }
  return joined;
}

/// A hole of 2000 edges with 100 islands in it.
Loops archipelago() {
  Loops all;
  all.add_circle({}, 1000.0, 2000);
  for (int i = 0; i < 100; ++i) {
    const double angle = 2.4 * i, radius = 90.0 * std::sqrt(i + 0.5);
    all.add_circle({radius * std::cos(angle), radius * std::sin(angle), 0.0}, 2.0, 20);
    all.loops.back().mean_normal = {0.0, 0.0, 1.0};
  }
  for (BoundaryLoop& loop : all.loops) {
    Vec3 sum;
    for (const std::uint64_t vertex : loop.vertices) sum = sum + all.vertices[vertex].position;
    loop.center = sum / static_cast<double>(loop.vertices.size());
    loop.radius = norm(all.vertices[loop.vertices[0]].position - loop.center);
    loop.area_vector = {0.0, 0.0, 1.0};
  }
  return all;
}

template <class Work>
ErrorKind kind_of_error(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.kind();
  }
  return ErrorKind::kNone;
}

}  // namespace

TEST_CASE("IslandsAreJoinedWhereTheyAreNearestToWhatIsJoined") {
  std::mt19937_64 random(3);
  for (int round = 0; round < 400; ++round) {
    // On a coarse grid most distances occur several times.
    const std::uint64_t side = round % 2 == 0 ? 5 : 1'000'000;
    Loops all;
    for (std::uint64_t l = 2 + random() % 9; l > 0; --l) {
      all.begin_loop();
      for (std::uint64_t i = 1 + random() % 7; i > 0; --i) {
        const std::array<std::uint64_t, 3> at = {random() % side, random() % side, random() % 2};
        all.add(
            {static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])});
      }
      std::vector<std::uint64_t>& vertices = all.loops.back().vertices;
      if (random() % 3 == 0) vertices.push_back(vertices.front());  // a loop that touches itself
    }
    const BoundaryLoop joined = join_islands(all.loops[0], all.loops, all.islands(), all.vertices);
    REQUIRE(joined.vertices == plainly_joined(all));
  }
}

TEST_CASE("IslandsAreFoundInTheHoleAroundThem") {
  const Loops all = archipelago();
  std::vector<std::uint8_t> is_hole(all.loops.size(), 0), may_be_island(all.loops.size(), 1);
  is_hole[0] = 1;
  may_be_island[0] = 0;
  CHECK(find_islands(all.loops, is_hole, may_be_island, all.vertices)[0] == all.islands());
  StopToken stop;
  stop.request();
  CHECK(kind_of_error([&] {
          find_islands(all.loops, is_hole, may_be_island, all.vertices, &stop);
        }) == ErrorKind::kInterrupted);
}

TEST_CASE("JoiningIslandsEndsWhenItIsAskedTo") {
  const Loops all = archipelago();
  const std::vector<std::uint32_t> islands = all.islands();
  const StopToken running;
  join_islands(all.loops[0], all.loops, islands, all.vertices, &running);
  // Each pair of corners is compared once: a look at least for every 2^20 of these.
  CHECK(running.checks() >= 4);
  CHECK(running.checks() <= 8);
  StopToken stop;
  stop.request();
  CHECK(kind_of_error([&] {
          join_islands(all.loops[0], all.loops, islands, all.vertices, &stop);
        }) == ErrorKind::kInterrupted);
}

}  // namespace orbweave
