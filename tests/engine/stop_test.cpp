// A request to stop ends every algorithm of a chunk, which looks for one each few thousand points
// at least: counted in looks, for time says nothing on a busy machine.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <numeric>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/cleaning/outliers.h"
#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "engine/normals/estimate_normals.h"
#include "engine/normals/orientation.h"
#include "engine/normals/orientation_graph.h"
#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/layer_thickness.h"
#include "engine/stitching/chunk_mesh.h"
#include "io/error.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

constexpr std::size_t kPoints = 20000;

using Work = std::function<void(const StopToken*)>;

struct NamedWork {
  std::string name;
  Work work;
};

/// The kind of the error that the work ends with.
ErrorKind kind_of_error(const Work& work, const StopToken& stop) {
  try {
    work(&stop);
    return ErrorKind::kNone;
  } catch (const Error& error) {
    return error.kind();
  }
}

ChunkPoints whole_chunk(const test::NamedCloud& named) {
  ChunkPoints points;
  points.positions = named.cloud.positions;
  points.normals = named.cloud.normals;
  points.global.resize(named.cloud.size());
  std::iota(points.global.begin(), points.global.end(), std::uint64_t{0});
  points.owned.assign(named.cloud.size(), 1);
  points.owned_end = static_cast<std::uint32_t>(named.cloud.size());
  return points;
}

/// Every algorithm that takes the points of a whole chunk at once.
std::vector<NamedWork> works(const test::NamedCloud& named, const ChunkPoints& chunk) {
  const auto& positions = named.cloud.positions;
  const auto& normals = named.cloud.normals;
  const auto end = static_cast<std::uint32_t>(named.cloud.size());
  const double reach = 2.0 * named.ball_radius;
  return {
      {"distances",
       [&positions](const StopToken* stop) {
         const Box all = {{-9.0, -9.0, -9.0}, {9.0, 9.0, 9.0}};
         const std::vector whole{SpacingSite{all, all, positions}};
         const SearchedSites sites(whole, stop);
         choose_radii(SampledNeighbors(sites, neighbors_for_radii(), stop), kPoints, 1, stop);
       }},
      {"layers",
       [&positions](const StopToken* stop) {
         const Box all = {{-9.0, -9.0, -9.0}, {9.0, 9.0, 9.0}};
         measure_layers(SearchedSites(std::vector{SpacingSite{all, all, positions}}, stop), stop);
       }},
      {"outliers",
       [&positions, end, reach](const StopToken* stop) {
         find_outliers(positions, 0, end, {.max_radius = reach, .stop = stop});
       }},
      {"merging",
       [&positions, end, reach](const StopToken* stop) {
         merge_points(positions, {}, 0, end, {0.2 * reach, 0.5, stop});
       }},
      {"thinning",
       [&positions, &normals, end, reach](const StopToken* stop) {
         thin_points(positions, normals, 0, end, {0.4 * reach, 0.5, stop});
       }},
      {"projection",
       [&positions, &normals, end, reach](const StopToken* stop) {
         project_points(positions, normals, 0, end, {reach, true, stop});
       }},
      {"normals",
       [&positions, end, reach](const StopToken* stop) {
         estimate_normals(positions, 0, end, {16, reach, stop});
       }},
      {"patches",
       [&positions, &normals, &chunk, end, reach](const StopToken* stop) {
         orient_patches(positions, normals, chunk.global, 0, end, {0.25, 10, reach, stop});
       }},
      {"ball pivoting",
       [&positions, &normals, &named](const StopToken* stop) {
         ball_pivoting(positions, normals, {}, {.ball_radii = {named.ball_radius}, .stop = stop});
       }},
      {"mesh of a chunk",
       [&positions, &normals, &named, &chunk](const StopToken* stop) {
         make_chunk_mesh(chunk,
                         ball_pivoting(positions, normals, {}, {.ball_radii = {named.ball_radius}}),
                         named.cloud.bounds(), 2.0 * named.ball_radius, stop);
       }},
  };
}

}  // namespace

TEST_CASE("ARequestToStopEndsEveryAlgorithmOfAChunk") {
  const test::NamedCloud named = test::noisy_torus(kPoints, 0.1, 7);
  const ChunkPoints chunk = whole_chunk(named);
  StopToken stop;
  stop.request();
  for (const auto& [name, work] : works(named, chunk)) {
    CAPTURE(name);
    CHECK(kind_of_error(work, stop) == ErrorKind::kInterrupted);
  }
}

TEST_CASE("NoAlgorithmGoesOverMoreThanABlockOfPointsWithoutALook") {
  const test::NamedCloud named = test::noisy_torus(kPoints, 0.1, 7);
  const ChunkPoints chunk = whole_chunk(named);
  for (const auto& [name, work] : works(named, chunk)) {
    CAPTURE(name);
    const StopToken stop;
    CHECK(kind_of_error(work, stop) == ErrorKind::kNone);
    CHECK(stop.checks() * kStopBlock >= kPoints);
  }
}

TEST_CASE("PointsThatAllLieInOneBallAreLookedAtOftener") {
  constexpr std::size_t kCrowd = 2000;
  constexpr std::uint64_t kCandidatesPerLook = std::uint64_t{1} << 16;
  const test::NamedCloud named = test::random_sphere(kCrowd, 3);  // of radius 1
  const StopToken stop;
  ball_pivoting(named.cloud.positions, named.cloud.normals, {},
                {.ball_radii = {0.9}, .stop = &stop});
  // Every point is a candidate of every other.
  CHECK(stop.checks() >= kCrowd * kCrowd / kCandidatesPerLook / 2);
}

TEST_CASE("TheGraphOfAllPatchesCanBeStopped") {
  constexpr std::uint32_t kNodes = 50000;
  std::vector<SignedEdge> edges;
  for (std::uint32_t i = 0; i + 1 < kNodes; ++i) edges.push_back({i, i + 1, 1.0 + i, 1.0 + i});
  const auto work = [&](const StopToken* token) { join_by_votes(kNodes, edges, {.stop = token}); };
  const StopToken stop;
  CHECK(kind_of_error(work, stop) == ErrorKind::kNone);
  CHECK(stop.checks() * kStopBlock >= kNodes);
  StopToken stopped;
  stopped.request();
  CHECK(kind_of_error(work, stopped) == ErrorKind::kInterrupted);
}

TEST_CASE("ResultsDoNotDependOnWhoLooks") {
  const test::NamedCloud named = test::noisy_torus(kPoints, 0.1, 8);
  const auto end = static_cast<std::uint32_t>(named.cloud.size());
  const double reach = 2.0 * named.ball_radius;
  const StopToken stop;
  CHECK(estimate_normals(named.cloud.positions, 0, end, {16, reach, &stop}).normals ==
        estimate_normals(named.cloud.positions, 0, end, {16, reach}).normals);
  const auto triangles = [&](const StopToken* token) {
    return ball_pivoting(named.cloud.positions, named.cloud.normals, {},
                         {.ball_radii = {named.ball_radius}, .stop = token})
        .triangles;
  };
  CHECK(triangles(&stop) == triangles(nullptr));
}

}  // namespace orbweave
