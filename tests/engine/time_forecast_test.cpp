// What stages a job is expected to run, and how their times follow from the job's size.
#include "engine/pipeline/budget/time_forecast.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "engine/pipeline/stage/stages.h"

namespace orbweave {
namespace {

ResolvedJob raw_job() {
  ResolvedJob job{};
  job.run.threads = 2;
  job.estimates_normals = true;
  return job;
}

double seconds_of(const std::vector<ExpectedStage>& stages, Stage stage) {
  const auto found = std::ranges::find(stages, std::string(name_of(stage)), &ExpectedStage::name);
  return found == stages.end() ? 0.0 : found->seconds;
}

TEST_CASE("AJobExpectsTheStagesOfItsOptions") {
  ResolvedJob job = raw_job();
  JobSize size;
  size.points = size.kept_points = 1'000'000;
  CHECK(seconds_of(expected_stages(job, size), Stage::kNormals) > 0.0);
  CHECK(seconds_of(expected_stages(job, size), Stage::kPatches) > 0.0);
  CHECK(seconds_of(expected_stages(job, size), Stage::kOutliers) == 0.0);
  CHECK(seconds_of(expected_stages(job, size), Stage::kPicture) == 0.0);
  job.cleaning.outlier_sigma = 3.0;
  job.normals.orientation = Orientation::kUp;
  job.output.picture = "mesh.png";
  CHECK(seconds_of(expected_stages(job, size), Stage::kPatches) == 0.0);
  CHECK(seconds_of(expected_stages(job, size), Stage::kOutliers) > 0.0);
  CHECK(seconds_of(expected_stages(job, size), Stage::kPicture) > 0.0);
  job.fill.enabled = false;
  CHECK(seconds_of(expected_stages(job, size), Stage::kHoles) == 0.0);
  job.estimates_normals = false;
  job.cleaning.outlier_sigma = 0.0;
  CHECK(expected_stages(job, size).front().name == name_of(Stage::kCount));
}

TEST_CASE("TilesOnAMapGridAreTheLeadersWorkAndTakeLonger") {
  ResolvedJob job = raw_job();
  job.output.tiles = true;
  JobSize size;
  size.points = size.kept_points = 1'000'000;
  const double by_chunk = seconds_of(expected_stages(job, size), Stage::kTiles);
  job.output.tile_size = 100.0;
  const double by_cell = seconds_of(expected_stages(job, size), Stage::kTiles);
  CHECK(by_cell > by_chunk);
  size.processes = 4;
  CHECK(seconds_of(expected_stages(job, size), Stage::kTiles) == by_cell);
}

TEST_CASE("ExpectedTimesFollowPointsRadiiThreadsAndLoops") {
  ResolvedJob job = raw_job();
  JobSize small;
  small.points = small.kept_points = 1'000'000;
  small.radii = 1;
  JobSize large = small;
  large.points = large.kept_points = 8'000'000;
  const auto one = expected_stages(job, small), eight = expected_stages(job, large);
  CHECK(seconds_of(eight, Stage::kReconstruct) ==
        Approx(8.0 * seconds_of(one, Stage::kReconstruct)));
  CHECK(seconds_of(eight, Stage::kMeasure) == Approx(seconds_of(one, Stage::kMeasure)));
  CHECK(sum_of_seconds(eight) < 8.0 * sum_of_seconds(one));
  JobSize radii = small;
  radii.radii = 4;
  CHECK(seconds_of(expected_stages(job, radii), Stage::kReconstruct) >
        3.0 * seconds_of(one, Stage::kReconstruct));
  JobSize loops = small;
  loops.loops = 0;
  CHECK(seconds_of(expected_stages(job, loops), Stage::kHoles) == 0.0);
  loops.loops = 1'000'000;
  CHECK(seconds_of(expected_stages(job, loops), Stage::kHoles) > 60.0);
  job.run.threads = 4;
  CHECK(seconds_of(expected_stages(job, small), Stage::kReconstruct) ==
        Approx(0.5 * seconds_of(one, Stage::kReconstruct)));
}

}  // namespace
}  // namespace orbweave
