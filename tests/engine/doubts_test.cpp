// Where the result of a run is in doubt, the run says so, and nothing that is not true.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "engine/pipeline/surface/in_core_methods.h"
#include "tests/engine/doubts.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using namespace orbweave;
using namespace orbweave::test;

namespace {

[[maybe_unused]] const bool in_memory = scratch_in_memory();

std::vector<std::string> without_resuming(std::vector<std::string> notes) {
  std::erase_if(notes, [](const std::string& note) { return note.starts_with("resuming"); });
  return notes;
}

}  // namespace

TEST_CASE("RadiiThatGrowForPointsOffAnySurfaceAreDoubted") {
  const char* const kDoubt = "most of which lie off the surface that their neighbours suggest";
  const ScratchDirectory scratch;
  for (const double share : {0.03, 0.1}) {
    NamedCloud noisy = random_sphere(4000, 11);
    NamedCloud sparse = noisy;
    Random random(3);
    for (int i = 0; i < static_cast<int>(share * 4000); ++i) {
      // Strays all through a box around the sphere, and as many points on a sparse sheet.
      noisy.cloud.positions.push_back({3.0 * random.uniform() - 1.5, 3.0 * random.uniform() - 1.5,
                                       3.0 * random.uniform() - 1.5});
      noisy.cloud.normals.push_back(normalized(noisy.cloud.positions.back()));
      sparse.cloud.positions.push_back(
          {0.4 * (i % 20 + 0.3 * random.uniform()), 0.4 * (i / 20 + 0.3 * random.uniform()), 2.0});
      sparse.cloud.normals.push_back({0, 0, 1});
    }
    put_in_order(noisy.cloud);
    put_in_order(sparse.cloud);
    for (const std::uint64_t chunk_points : {1000u, 1'000'000u}) {
      Job job = job_without_fill(scratch, noisy);
      job.partition.chunk_points = chunk_points;
      CHECK(warns_of(job, kDoubt));
    }
    Job given = job_without_fill(scratch, noisy);
    given.reconstruct.ball_radii = {0.1};
    CHECK_FALSE(warns_of(given, kDoubt));
    const RunReport of_sparse = run(job_without_fill(scratch, sparse));
    CHECK(of_sparse.radii.size() >= 3);
    CHECK_FALSE(warns_of(job_without_fill(scratch, sparse), kDoubt));
  }
}

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

TEST_CASE("AClosedSurfaceOfUndersampledPointsIsWarnedOf") {
  if (!has_voronoi_family()) return;
  // The sheet's other side lies 0.02 away, less than half of the spacing.
  NamedCloud plate = uneven_sheet({});
  for (const Vec3& p : uneven_sheet({0.013, 0.017, -0.02}).cloud.positions) {
    plate.cloud.positions.push_back(p);
    plate.cloud.normals.push_back({0, 0, -1});
  }
  put_in_order(plate.cloud);
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, plate);
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  CHECK(warns_of(job, "points are sampled too sparsely for tight_cocone"));
  // The rim of a single sheet is undersampled, too.
  job = job_without_fill(scratch, uneven_sheet({}));
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  CHECK_FALSE(warns_of(job, "sampled too sparsely"));
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

TEST_CASE("TwoSurfacesThatLieCloseAreNotTakenForNoiseAlone") {
  ScratchDirectory scratch;
  const std::string other = "), or two surfaces this close, which cleaning would merge; above 9 %";
  for (const double steps : {1.5, 2.5})
    CHECK(warns_of(job_without_fill(scratch, thin_plate(steps)), other));
  CHECK_FALSE(warns_of(job_without_fill(scratch, noisy_torus(4000, 0.4, 3)), "two surfaces"));
  Job job = job_without_fill(scratch, thin_plate(2.0));
  job.cleaning.automatic = true;
  CHECK_THAT(run(job).cleaning.reason, Contains(other));
}

TEST_CASE("AResumedRunSaysOfThePointsWhatAnUndisturbedOneSays") {
  ScratchDirectory scratch;
  NamedCloud sheet = uneven_sheet({3.0e5, 1.0e6, 100.0});
  constexpr std::size_t kPoints = 1200;
  sheet.cloud.positions.resize(kPoints);
  sheet.cloud.normals.resize(kPoints);
  Random random(11);
  for (Vec3& p : sheet.cloud.positions) p.z += 0.3 * random.uniform();
  sheet.cloud = as_floats(sheet.cloud);
  sheet.cloud.positions.back() = {1e9, 0.0, 0.0};
  put_in_order(sheet.cloud);
  Job job = job_without_fill(scratch, sheet);
  job.partition.chunk_points = 500;
  const bool estimates = GENERATE(false, true);
  job.normals.source = estimates ? NormalSource::kEstimate : NormalSource::kFile;
  RecordingProgress progress;
  const StopToken never;
  const RunReport whole = run_job(job, {"test"}, progress, never);
  CHECK(std::ranges::any_of(whole.notes, [](const std::string& note) {
    return note.starts_with("points that are no measurements are left out");
  }));
  REQUIRE(whole.warnings.size() >= 2);
  for (const std::string& stage : std::set(progress.stages.begin(), progress.stages.end())) {
    CAPTURE(stage, estimates);
    const RunReport resumed = resumed_at(job, stage);
    CHECK(resumed.warnings == whole.warnings);
    CHECK(without_resuming(resumed.notes) == whole.notes);
  }
}

TEST_CASE("TwoLayersThatCleaningMergesAreWarnedOf") {
  ScratchDirectory scratch;
  const auto warns = [&](const NamedCloud& named) {
    Job job = job_without_fill(scratch, without_normals(named));
    job.cleaning.automatic = true;
    return warns_of(job, "the points lie in two layers");
  };
  CHECK(warns(thin_plate(1.0)));
  CHECK_FALSE(warns(noisy_torus(20000, 0.3, 3)));
  CHECK_FALSE(warns(noisy_torus(20000, 0.6, 3)));
}

TEST_CASE("TwoLayersThatNothingMergesAreWarnedOf") {
  // A sheet, and a second scan of a sixth of it that rises up to a spacing and a half above it.
  // Most places are thin layers, so that nothing is cleaned, whether that is asked for or not.
  ScratchDirectory scratch;
  const auto sheets = [](double height) {
    constexpr double kSpacing = 1.0 / 128.0;
    NamedCloud named;
    Random random(5);
    for (int i = 0; i < 128; ++i)
      for (int j = 0; j < 128; ++j)
        for (int scan = 0; scan < (6 * i < 128 ? 2 : 1); ++scan) {
          const double x = i + 0.4 * random.uniform(), y = j + 0.4 * random.uniform();
          named.cloud.positions.push_back(kSpacing * Vec3{x, y, scan * height * j / 128.0});
        }
    named.ball_radius = 1.5 * kSpacing;
    put_in_order(named.cloud);
    return named;
  };
  for (const bool automatic : {true, false}) {
    Job job = job_without_fill(scratch, sheets(1.5));
    job.cleaning.automatic = automatic;
    CAPTURE(automatic);
    CHECK(warns_of(job, "and no smoothing makes one of them"));
    CHECK_FALSE(warns_of(job, "cleaning makes one of them"));
    job = job_without_fill(scratch, sheets(0.0));
    CHECK_FALSE(warns_of(job, "in two layers"));
  }
}

TEST_CASE("LevelsThatDoNotReachTheSparsePartAreWarnedOf") {
  // Half of a sheet has a twentieth of the points of the other half.
  ScratchDirectory scratch;
  const auto sheet = [](int sparser) {
    NamedCloud named;
    Random random(7);
    for (int half = 0; half < 2; ++half) {
      const int along = half == 0 ? 128 : 128 / sparser;
      for (int i = 0; i < along / 2; ++i)
        for (int j = 0; j < along; ++j) {
          const double x = (i + 0.4 * random.uniform()) / along;
          named.cloud.positions.push_back(
              {x + 0.5 * half, (j + 0.4 * random.uniform()) / along, 0.0});
        }
    }
    named.ball_radius = 1.5 / 128.0;
    put_in_order(named.cloud);
    return named;
  };
  const auto job_of = [&](int sparser, int levels) {
    Job job = job_without_fill(scratch, sheet(sparser));
    job.reconstruct.ball_radii = {};
    job.reconstruct.levels = levels;
    return job;
  };
  const std::string what = "it may stay open; reconstruct.levels";
  CHECK(warns_of(job_of(5, 2), what));
  CHECK(doubts(job_of(5, 2), what));
  CHECK_FALSE(warns_of(job_of(5, 0), what));
  CHECK_FALSE(warns_of(job_of(1, 2), what));
  // Radii that are given are as they are wanted.
  Job given = job_of(5, 2);
  given.reconstruct.ball_radii = {1.5 / 128.0};
  CHECK_FALSE(warns_of(given, what));
}

TEST_CASE("ThousandsOfTinyChunksAreWarnedOf") {
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, noisy_torus(12'000, 0.1, 3));
  const std::string what = "is faster and makes the same mesh";
  CHECK_FALSE(doubts(job, what));
  job.partition.chunk_points = 100;
  CHECK_FALSE(doubts(job, what));
  job.partition.chunk_points = 10;
  CHECK(doubts(job, what));
}

TEST_CASE("ARunOfThousandsOfTinyChunksWarnsOfThem", "[costly]") {
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, noisy_torus(2'000, 0.1, 3));
  job.partition.chunk_points = 2;
  CHECK(warns_of(job, "is faster and makes the same mesh"));
}

TEST_CASE("PointsThatComeTwiceAreWarnedOf") {
  ScratchDirectory scratch;
  NamedCloud twice = without_normals(noisy_torus(20000, 0.1, 3));
  const NamedCloud once = twice;
  Random random(8);
  for (const Vec3 p : once.cloud.positions)
    twice.cloud.positions.push_back(p + 1e-4 * once.ball_radius * random.direction());
  put_in_order(twice.cloud);
  const std::string what = "closer than a twentieth of the point spacing";
  CHECK_FALSE(warns_of(job_without_fill(scratch, once), what));
  Job job = job_without_fill(scratch, twice);
  CHECK(warns_of(job, what));
  job.cleaning.thin_to_spacing = 0.1 * once.ball_radius;
  CHECK_FALSE(warns_of(job, what));
}
