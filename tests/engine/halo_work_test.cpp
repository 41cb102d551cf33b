// Chunks whose halos are most of the work are put together.
#include "engine/pipeline/points/halo_work.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "partition/count_grid.h"

namespace orbweave {
namespace {

/// A Fibonacci sphere of radius 1; three points of ten in a cap of radius `cap` about +z.
std::vector<Vec3> sphere(int points, double cap) {
  const double turn = std::numbers::pi * (3.0 - std::sqrt(5.0));
  const int crowd = cap > 0.0 ? 3 * points / 10 : 0;
  std::vector<Vec3> all;
  const auto add = [&](double z, int i) {
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
    all.push_back({r * std::cos(turn * i), r * std::sin(turn * i), z});
  };
  for (int i = 0; i < points - crowd; ++i) add(1.0 - (2.0 * i + 1.0) / (points - crowd), i);
  for (int i = 0; i < crowd; ++i) add(1.0 - cap * cap / 2.0 * (i + 0.5) / crowd, i);
  return all;
}

struct Cut {
  std::vector<CrowdedPlace> places;
  Octree octree;
};

Cut cut(const std::vector<Vec3>& points, std::uint64_t chunk_points) {
  CountGrid grid;
  grid.add(points);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  return {crowded_places(grid, root), cut_octree(grid, root, chunk_points)};
}

}  // namespace

TEST_CASE("PlacesHoldEveryPointOnce") {
  const Cut even = cut(sphere(50'000, 0.0), 10'000);
  std::uint64_t points = 0;
  for (const CrowdedPlace& place : even.places) points += place.points;
  CHECK(points == 50'000);
  CHECK(even.octree.chunks().size() > 4);
  // No halo, and one that reaches everywhere.
  CHECK(halo_work(even.places, even.octree, 0.0) == Approx(1.0).margin(0.15));
  CHECK(halo_work(even.places, even.octree, 4.0) == Approx(even.octree.chunks().size()));
}

TEST_CASE("ChunksStayApartOnAnEvenSurface") {
  const Cut even = cut(sphere(50'000, 0.0), 10'000);
  const Octree kept =
      without_needless_halos(even.places, even.octree, 0.1, 10'000, {50'000, 50'000});
  CHECK(kept.chunks().size() == even.octree.chunks().size());
}

TEST_CASE("ChunksAroundACrowdAreOneAsFarAsMemoryAllows") {
  const Cut crowded = cut(sphere(50'000, 0.1), 10'000);
  REQUIRE(halo_work(crowded.places, crowded.octree, 0.3) > 2.0);
  CHECK(without_needless_halos(crowded.places, crowded.octree, 0.3, 10'000, {50'000, 50'000})
            .chunks()
            .size() == 1);
  const Octree limited =
      without_needless_halos(crowded.places, crowded.octree, 0.3, 10'000, {20'000, 50'000});
  CHECK(limited.chunks().size() > 1);
  for (const Chunk& chunk : limited.chunks()) CHECK(chunk.points <= 20'000);
  // Where the halos leave no room, chunks stay as they are.
  CHECK(without_needless_halos(crowded.places, crowded.octree, 0.3, 10'000, {50'000, 49'999})
            .chunks()
            .size() > 1);
}

}  // namespace orbweave
