// Where the result of a run is in doubt, the run says so, and nothing that is not true.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "tests/support/clouds.h"
#include "tests/support/jobs.h"

using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using namespace orbweave;
using namespace orbweave::test;

namespace {

Job job_without_fill(const ScratchDirectory& scratch, const NamedCloud& named) {
  Job job = job_for(scratch, named);
  job.reconstruct.ball_radii.clear();
  job.fill.enabled = false;
  return job;
}

bool warns_of(const Job& job, const std::string& what) {
  const std::vector<std::string> warnings = run(job).warnings;
  return std::ranges::any_of(warnings, [&](const std::string& warning) {
    return warning.find(what) != std::string::npos;
  });
}

}  // namespace

TEST_CASE("TheReasonOfTheCleaningTellsWhatWasDoneFromWhatWasNot") {
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, noisy_torus(4000, 0.4, 3));
  CHECK_THAT(run(job).cleaning.reason,
             Contains("above 9 %: not cleaned; cleaning.auto would drop outliers beyond 4 ") &&
                 Contains(", smooth in 2 passes of radius ") &&
                 Contains(", thin to a spacing of "));
  job.cleaning.merge_tolerance = 1e-3;
  job.cleaning.cluster_points = 3;
  CHECK_THAT(run(job).cleaning.reason,
             EndsWith("above 9 %: dropped clusters of fewer than 3 points, "
                      "merged points within 0.001"));
  job.cleaning.automatic = true;
  CHECK_THAT(run(job).cleaning.reason, Contains("dropped outliers beyond 4 ") &&
                                           Contains(", smoothed in 2 passes of radius ") &&
                                           Contains(", thinned to a spacing of ") &&
                                           Contains("fewer than 3 points"));
}

TEST_CASE("NoiseThatNothingSmoothsOrThinsIsWarnedOf") {
  ScratchDirectory scratch;
  const Job job = job_without_fill(scratch, noisy_torus(4000, 0.4, 3));
  CHECK(warns_of(job, "above 9 %"));
  Job other = job;
  other.cleaning.merge_tolerance = 1e-3;
  CHECK(warns_of(other, "above 9 %"));
  other = job;
  other.cleaning.outlier_sigma = 6.0;
  other.cleaning.cluster_points = 3;
  CHECK(warns_of(other, "above 9 %"));
  other = job;
  other.cleaning.thin_to_spacing = 0.3;
  CHECK_FALSE(warns_of(other, "above 9 %"));
  other = job;
  other.cleaning.smooth_radius = 0.3;
  CHECK_FALSE(warns_of(other, "above 9 %"));
}

TEST_CASE("AFifthOfThePointsThatTheMeshLacksIsWarnedOf") {
  const auto job_of = [](const ScratchDirectory& scratch, std::size_t every) {
    NamedCloud named = noisy_torus(4000, 0.0, 3);
    for (std::size_t i = 0; i < named.cloud.size(); i += every)
      named.cloud.normals[i] = {std::nan(""), 0.0, 0.0};
    return job_without_fill(scratch, named);
  };
  ScratchDirectory scratch;
  CHECK_FALSE(warns_of(job_of(scratch, 10), "are not in the mesh"));
  CHECK(warns_of(job_of(scratch, 2), " points are not in the mesh ("));
  CHECK(warns_of(job_of(scratch, 2), " normal not finite); ball radi"));
}

TEST_CASE("PointsThatTheJobDropsAreNotMissing") {
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, noisy_torus(4000, 0.0, 3));
  job.cleaning.thin_to_spacing = 0.15;
  const RunReport report = run(job);
  CHECK(report.points_dropped.at("thinned") > 2000);
  CHECK(report.warnings.empty());
}

TEST_CASE("ABallThatPassesOverPointsIsWarnedOfWithItsWidthInSpacings") {
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, noisy_torus(4000, 0.5, 3));
  job.reconstruct.ball_radii = {0.35};
  const RunReport report = run(job);
  REQUIRE(report.points_unused * 5 > report.points_read);
  REQUIRE(report.warnings.size() == 2);
  CHECK_THAT(report.warnings.back(), Contains(" that no triangle uses); ball radius 0.35, ") &&
                                         Contains(" times the point spacing ") &&
                                         Contains("pass over points"));
}
