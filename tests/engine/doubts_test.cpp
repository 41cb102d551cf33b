// Where the result of a run is in doubt, the run says so, and nothing that is not true.
#include <algorithm>
#include <catch2/catch.hpp>
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
