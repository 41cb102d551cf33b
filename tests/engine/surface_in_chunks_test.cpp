// A cloud in memory goes chunk by chunk to the triangles of the whole.
#include "engine/ball_pivoting/surface_in_chunks.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/ball_pivoting/halo_width.h"
#include "io/bounds.h"
#include "partition/canonical_order.h"
#include "partition/cloud_counts.h"
#include "partition/octree.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using test::NamedCloud;

/// In the canonical order of the bounds' own cube.
PointCloud sorted(NamedCloud named) {
  PointCloud cloud = std::move(named.cloud);
  sort_canonically(cloud, root_cube(bounds_of(cloud.positions)));
  return cloud;
}

void check_chunks(const PointCloud& cloud, const std::vector<double>& radii,
                  std::uint64_t chunk_points) {
  const CloudCounts counts(cloud.positions);
  const Octree octree = cut_octree(counts, root_cube(counts.bounds()), chunk_points);
  const BallPivotingOptions options{.ball_radii = radii};
  const auto whole = ball_pivoting(cloud.positions, cloud.normals, {}, options).triangles;
  REQUIRE_FALSE(whole.empty());
  CHECK((triangles_in_chunks(cloud.positions, cloud.normals, options, octree) == whole));
}

TEST_CASE("ChunksOfACloudInMemoryHaveTheTrianglesOfTheWhole", "[costly]") {
  const NamedCloud torus = test::noisy_torus(100'000, 0.2, 5);
  const double radius = torus.ball_radius;
  const PointCloud cloud = sorted(torus);
  for (const std::uint64_t chunk_points : {5'000, 30'000, 99'999}) {
    INFO(chunk_points);
    check_chunks(cloud, {radius}, chunk_points);
    check_chunks(cloud, {0.7 * radius, radius, 1.5 * radius}, chunk_points);
  }
}

TEST_CASE("ACloudOfUnevenDensityInMemoryHasTheTrianglesOfTheWhole") {
  const NamedCloud sphere = test::random_sphere(20'000, 3);
  check_chunks(sorted(sphere), {sphere.ball_radius, 2.0 * sphere.ball_radius}, 3'000);
}

TEST_CASE("ChunksThatWouldBeAllHaloAreNotCut") {
  const NamedCloud sphere = test::random_sphere(2'000, 4);
  const PointCloud cloud = sorted(sphere);
  const double radius = sphere.ball_radius;
  REQUIRE(halo_width(std::vector<double>{radius}) > 0.05);
  check_chunks(cloud, {radius}, 100);
}

TEST_CASE("ACloudOfOneChunkIsTheWhole") {
  const NamedCloud sphere = test::random_sphere(2'000, 4);
  const PointCloud cloud = sorted(sphere);
  check_chunks(cloud, {sphere.ball_radius}, 2'000);
  const BallPivotingOptions options{.ball_radii = {sphere.ball_radius}};
  CHECK(triangles_in_chunks({}, {}, options, Octree()).empty());
}

}  // namespace
}  // namespace orbweave
