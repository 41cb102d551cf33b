// Jobs on scans whose noise is not the same everywhere: what is clean stays, what is not is
// cleaned, and the mesh is the same for any partition.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/stage/cleaning_rule.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/clouds.h"
#include "tests/support/jobs.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

constexpr double kSpacing = 0.02;

/// A sheet of 8 by 1.2 whose noise grows along x: none up to 3, two spacings at the end.
NamedCloud growing_noise() {
  Random random(7);
  NamedCloud named;
  named.name = "growing noise";
  named.ball_radius = 1.3 * kSpacing;
  PointCloud& cloud = named.cloud;
  cloud.schema.has_normals = true;
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 60; ++j) {
      const double x = kSpacing * (i + 0.2 * random.uniform());
      const double noise = 2.0 * kSpacing * std::max(0.0, x - 3.0) / 5.0;
      cloud.positions.push_back({x, kSpacing * (j + 0.2 * random.uniform()),
                                 1.7 * noise * (2.0 * random.uniform() - 1.0)});
      cloud.normals.push_back({0, 0, 1});
    }
  put_in_order(cloud);
  return named;
}

Job cleaning_job(const ScratchDirectory& scratch, const NamedCloud& named) {
  Job job = job_for(scratch, named);
  job.cleaning.automatic = true;
  job.reconstruct.ball_radii.clear();
  job.fill.enabled = false;
  return job;
}

}  // namespace

TEST_CASE("CleanPartsOfANoisyScanStayToTheBitAndTheRestIsSmoothed", "[costly]") {
  ScratchDirectory scratch;
  const NamedCloud named = growing_noise();
  const Job job = cleaning_job(scratch, named);
  const RunReport report = run(job);
  CHECK(report.cleaning.is_local);
  CHECK(report.cleaning.untouched_share > 0.2);
  CHECK(report.cleaning.untouched_share < 0.6);
  CHECK(report.cleaning.most_radius > 2.0 * report.cleaning.least_radius);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  const auto is_before = [](Vec3 a, Vec3 b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::vector<Vec3> scanned = named.cloud.positions;
  std::sort(scanned.begin(), scanned.end(), is_before);
  std::size_t clean = 0, given = 0;
  double off = 0.0;
  std::size_t smoothed = 0;
  for (const Vec3& p : mesh.vertices.positions) {
    if (p.x < 2.0) {
      ++clean;
      given += std::binary_search(scanned.begin(), scanned.end(), p, is_before) ? 1 : 0;
    } else if (p.x > 6.0) {
      off += std::abs(p.z);
      ++smoothed;
    }
  }
  CHECK(clean > 5500);
  CHECK(given == clean);
  CHECK(smoothed > 50);
  // Scanned points lie 1.4 spacings off on average.
  CHECK(off < 0.5 * kSpacing * static_cast<double>(smoothed));
}

TEST_CASE("LocalCleaningGivesTheSameBytesForAnyPartitionAndOrder", "[slow]") {
  ScratchDirectory scratch;
  NamedCloud named = growing_noise();
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  Job job = cleaning_job(scratch, named);
  job.normals.orientation = Orientation::kUp;
  job.cleaning.min_surfaceness = 0.1;
  const std::string expected = mesh_bytes(job);
  for (const std::uint64_t chunk_points : {700u, 4000u, 1'000'000'000u}) {
    job.partition.chunk_points = chunk_points;
    job.run.threads = chunk_points == 4000u ? 5 : 1;
    INFO("chunk_points " << chunk_points);
    REQUIRE((mesh_bytes(job) == expected));
  }
  shuffle(named.cloud, 3);
  write_cloud(job.input.files.front(), named.cloud);
  REQUIRE((mesh_bytes(job) == expected));
}

TEST_CASE("NumbersOfTheJobHoldEverywhere") {
  ScratchDirectory scratch;
  Job job = cleaning_job(scratch, growing_noise());
  job.cleaning.smooth_radius = 0.1;
  const RunReport report = run(job);
  CHECK_FALSE(report.cleaning.is_local);
  CHECK(report.cleaning.least_radius == 0.1);
  CHECK(report.cleaning.most_radius == 0.1);
}

TEST_CASE("SmallClustersAreDroppedAndCountedOnRequest") {
  ScratchDirectory scratch;
  NamedCloud named = grid_sheet(40, 0.0);
  for (int i = 0; i < 6; ++i) {
    named.cloud.positions.push_back({20.0 + 0.4 * i, 20.0, 60.0});
    named.cloud.normals.push_back({0, 0, 1});
  }
  put_in_order(named.cloud);
  Job job = job_for(scratch, named);
  CHECK_FALSE(run(job).points_dropped.contains(text_of(DropReason::kCluster)));
  job.cleaning.cluster_points = 10;
  CHECK(run(job).points_dropped.at(text_of(DropReason::kCluster)) == 6);
  job.cleaning.cluster_points = 6;
  CHECK_FALSE(run(job).points_dropped.contains(text_of(DropReason::kCluster)));
}

TEST_CASE("PointsThatCarryNoSurfaceAreDroppedAndCountedOnRequest") {
  ScratchDirectory scratch;
  NamedCloud named = grid_sheet(40, 0.0);
  for (int i = 0; i < 120; ++i) {
    named.cloud.positions.push_back({0.3 * i, 20.0, 30.0});
    named.cloud.normals.push_back({0, 0, 1});
  }
  put_in_order(named.cloud);
  Job job = job_for(scratch, named);
  job.cleaning.min_surfaceness = 0.1;
  const auto dropped = run(job).points_dropped;
  CHECK(dropped.at(text_of(DropReason::kNoSurface)) >= 118);
  CHECK(dropped.at(text_of(DropReason::kNoSurface)) <= 124);
}

TEST_CASE("TheReachOfCleaningFollowsTheLargestRadius") {
  Partition scans;
  scans.normal_radius = 0.05;
  scans.spacing = 0.01;
  scans.layers = {.thickness = 0.002,
                  .spacing = 0.01,
                  .radius = 0.1,
                  .measured = 100,
                  .thick_share = 0.6,
                  .largest_radius = 0.9};
  ResolvedJob job;
  job.cleaning.automatic = true;
  CHECK(reach_of_cleaning(job, scans) > 0.9);
  CHECK(cleaning_for(job.cleaning, scans).most_radius == 0.9);
  scans.layers.largest_radius = 0.0375;
  CHECK(reach_of_cleaning(job, scans) < 0.4);
}
