// The trial of a plan: samples of a cloud, and what they tell of a job.
#include "engine/planning/trial.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "io/error.h"
#include "partition/cloud_counts.h"
#include "tests/support/jobs.h"

namespace orbweave::test {
namespace {

std::vector<PointCloud> samples_of(const PointCloud& cloud, std::size_t batch) {
  const CloudCounts counts(cloud.positions);
  TrialSamples samples(root_cube(counts.bounds()), counts);
  PointCloud part;
  part.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    part.append(cloud, i);
    if (part.size() < batch && i + 1 < cloud.size()) continue;
    samples.add(part);
    part.clear();
  }
  return samples.take();
}

/// The positions of each sample, in no order.
std::vector<std::multiset<double>> contents_of(const std::vector<PointCloud>& samples) {
  std::vector<std::multiset<double>> contents;
  for (const PointCloud& sample : samples) {
    contents.emplace_back();
    for (const Vec3& p : sample.positions) contents.back().insert(p.x);
  }
  return contents;
}

}  // namespace

TEST_CASE("SamplesOfATrialAreTheSameInAnyOrderOfThePoints") {
  const PointCloud cloud = painted_torus(200'000, 0.1, 3).cloud;
  PointCloud turned;
  turned.schema = cloud.schema;
  for (std::size_t i = cloud.size(); i-- > 0;) turned.append(cloud, i);
  const std::vector<PointCloud> samples = samples_of(cloud, 1'000);
  CHECK(samples.size() == 8);
  for (const PointCloud& sample : samples) CHECK(sample.size() <= 16'384);
  CHECK(contents_of(samples) == contents_of(samples_of(turned, 77'777)));
}

TEST_CASE("ASmallCloudIsASampleAsAWhole") {
  const PointCloud cloud = painted_torus(5'000, 0.1, 3).cloud;
  const std::vector<PointCloud> samples = samples_of(cloud, 1'000);
  REQUIRE(samples.size() == 1);
  CHECK(samples.front().size() == cloud.size());
}

TEST_CASE("ADensePlaceMakesNoSampleLong") {
  PointCloud cloud = painted_torus(20'000, 0.1, 3).cloud;
  const PointCloud once = cloud;
  for (int times = 0; times < 100'000; ++times) cloud.append(once, 0);
  for (const PointCloud& sample : samples_of(cloud, 10'000)) CHECK(sample.size() <= 32'768);
}

TEST_CASE("ATrialTellsWhatThinningKeeps") {
  NamedCloud named = painted_torus(30'000, 0.3, 5);
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  TrialOptions options;
  options.estimates_normals = true;
  options.estimate.max_radius = 4.0 * named.ball_radius;
  options.reach_of_outliers = 4.0 * named.ball_radius;
  options.cleaning.outlier_sigma = 4.0;
  options.cleaning.smooth_radius = 2.0 * named.ball_radius;
  options.cleaning.thin_to_spacing = 1.5 * named.ball_radius;
  options.threads = 2;
  const TrialResult result = run_trial(samples_of(named.cloud, 1'000), options);
  CHECK(result.points <= 30'000);
  CHECK(result.points > 20'000);
  CHECK(result.points_kept < 20'000);
  CHECK(result.points_kept > 2'000);
  CHECK(result.cpu_seconds > 0.0);
}

TEST_CASE("ASampleWithoutATriangleIsNoError") {
  PointCloud line;
  line.schema.has_normals = true;
  for (int i = 0; i < 100; ++i) {
    line.positions.push_back({static_cast<double>(i), 0.0, 0.0});
    line.normals.push_back({0.0, 0.0, 1.0});
  }
  TrialOptions options;
  options.ball_radii = {1.0};
  const TrialResult result = run_trial({line}, options);
  CHECK(result.points == 100);
  CHECK(result.points_kept == 0);
}

TEST_CASE("ATrialStopsWhenItIsAsked") {
  const NamedCloud named = painted_torus(30'000, 0.1, 5);
  StopToken stop;
  stop.request();
  TrialOptions options;
  options.ball_radii = {named.ball_radius};
  options.stop = &stop;
  try {
    run_trial(samples_of(named.cloud, 1'000), options);
    FAIL("the trial went on");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kInterrupted);
  }
}

}  // namespace orbweave::test
