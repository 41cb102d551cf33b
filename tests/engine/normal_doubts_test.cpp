// Normals that are in doubt: runs and plans say so, and nothing that is not true.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "tests/engine/doubts.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

/// An even sphere whose normals `change` turns.
NamedCloud sphere_with(const std::function<Vec3(Vec3 place, Vec3 normal)>& change) {
  NamedCloud named = random_sphere(12000, 11);
  for (std::size_t i = 0; i < named.cloud.size(); ++i)
    named.cloud.normals[i] = change(named.cloud.positions[i], named.cloud.normals[i]);
  return named;
}

}  // namespace

TEST_CASE("NormalsThatAreAllTheSameAreDoubtedWhereThePointsLieInNoPlane") {
  const char* const kDoubt = "the normals of the scan are all (0, 0, 1)";
  const ScratchDirectory scratch;
  NamedCloud torus = noisy_torus(3000, 0.0, 3);
  const NamedCloud sound = torus;
  std::ranges::fill(torus.cloud.normals, Vec3{0, 0, 1});
  for (const std::uint64_t chunk_points : {400u, 1'000'000u}) {
    Job job = job_without_fill(scratch, torus);
    job.partition.chunk_points = chunk_points;
    CHECK(warns_of(job, kDoubt));
  }
  CHECK_FALSE(warns_of(job_without_fill(scratch, sound), "the normals of the scan are all"));
  CHECK_FALSE(warns_of(job_without_fill(scratch, uneven_sheet({})), "the normals of the scan"));
  Job estimated = job_without_fill(scratch, torus);
  estimated.normals.source = NormalSource::kEstimate;
  CHECK_FALSE(warns_of(estimated, "the normals of the scan"));
}

TEST_CASE("OnePointWithAnotherNormalIsSeenInAnyCut") {
  const ScratchDirectory scratch;
  NamedCloud torus = noisy_torus(30000, 0.0, 3);
  std::ranges::fill(torus.cloud.normals, Vec3{0, 0, 1});
  put_in_order(torus.cloud);
  torus.cloud.normals[torus.cloud.size() / 4] = {0, 0, -1};
  for (const std::uint64_t chunk_points : {2000u, 1'000'000u}) {
    Job job = job_without_fill(scratch, torus);
    job.partition.chunk_points = chunk_points;
    CHECK_FALSE(warns_of(job, "the normals of the scan are all"));
  }
}

TEST_CASE("NormalsOfTheFileThatFaceBothSidesAreWarnedOf") {
  ScratchDirectory scratch;
  const auto warns = [&](const std::function<Vec3(Vec3, Vec3)>& change, const std::string& what) {
    return warns_of(job_without_fill(scratch, sphere_with(change)), what);
  };
  CHECK(warns([](Vec3 p, Vec3 n) { return p.x > 0.3 ? -n : n; }, "the normals contradict"));
  CHECK(warns(
      [](Vec3 p, Vec3 n) {
        return norm(p - Vec3{1, 0, 0}) < 0.5 ? -n : n;
      },
      "the normals contradict"));
  CHECK(warns([](Vec3, Vec3 n) { return n.z < 0.0 ? -n : n; }, "the normals contradict"));
  CHECK_FALSE(warns([](Vec3, Vec3 n) { return n; }, "the normals"));
  CHECK_FALSE(warns([](Vec3, Vec3 n) { return -n; }, "the normals contradict"));
}

TEST_CASE("NormalsOfTheFileThatAreNotThoseOfThePointsAreWarnedOf") {
  ScratchDirectory scratch;
  const auto warns = [&](const std::function<Vec3(Vec3, Vec3)>& change) {
    return warns_of(job_without_fill(scratch, sphere_with(change)), "the normals do not fit");
  };
  CHECK(warns([](Vec3, Vec3 n) { return Vec3{n.x, n.z, -n.y}; }));
  CHECK(warns([](Vec3, Vec3 n) { return 0.5 * (n + Vec3{1, 1, 1}); }));  // colours of a normal map
  CHECK_FALSE(warns([](Vec3, Vec3 n) { return n; }));
}

TEST_CASE("GroundWhoseNormalsOfTheFileFaceDownIsWarnedOf") {
  const std::string what = "face down where the surface is level";
  const ScratchDirectory scratch;
  NamedCloud ground = uneven_sheet({});
  const auto job_of = [&](Orientation orientation) {
    Job job = job_without_fill(scratch, ground);
    job.normals.orientation = orientation;
    return job;
  };
  CHECK_FALSE(warns_of(job_of(Orientation::kGround), what));
  for (Vec3& normal : ground.cloud.normals) normal = {0, 0, -1};
  CHECK(warns_of(job_of(Orientation::kGround), what));
  // Of a depth camera z is the direction in which it looks.
  CHECK_FALSE(warns_of(job_of(Orientation::kAuto), what));
  Job estimated = job_of(Orientation::kGround);
  estimated.normals.source = NormalSource::kEstimate;
  CHECK_FALSE(warns_of(estimated, what));
}

TEST_CASE("TheSidesOfAThinPlateAreNoContradiction") {
  ScratchDirectory scratch;
  for (const double steps : {0.5, 1.0, 2.0})
    CHECK_FALSE(warns_of(job_without_fill(scratch, thin_plate(steps)), "the normals"));
}

TEST_CASE("AWrongPlaceOfTheScannerIsWarnedOf") {
  ScratchDirectory scratch;
  Job job = job_without_fill(scratch, without_normals(random_sphere(12000, 11)));
  job.input.scanner = ScannerPlace{{4.0, 0.0, 0.0}, false};
  CHECK(warns_of(job, "check the place of each scanner"));
}

TEST_CASE("ContradictionsAreTheSameInAnyCut") {
  ScratchDirectory scratch;
  Job job =
      job_without_fill(scratch, sphere_with([](Vec3 p, Vec3 n) { return p.x > 0.3 ? -n : n; }));
  const auto said = [&](std::uint64_t chunk_points) {
    job.partition.chunk_points = chunk_points;
    std::vector<std::string> found;
    for (const std::string& warning : run(job).warnings)
      if (warning.find("the normals") != std::string::npos) found.push_back(warning);
    return found;
  };
  const std::vector<std::string> whole = said(100000);
  CHECK(whole.size() == 1);
  CHECK(said(1500) == whole);
}

TEST_CASE("NotesTellOfASmallPartWhoseSideIsAGuess") {
  // A board stands apart from the ground, with 3 % of the surface.
  ScratchDirectory scratch;
  const auto boards_of = [&](int along) {
    NamedCloud named;
    Random random(9);
    const auto jitter = [&] { return 0.2 * random.uniform(); };
    for (int i = 0; i < 100; ++i)
      for (int j = 0; j < 100; ++j)
        named.cloud.positions.push_back({i + jitter(), j + jitter(), 0.1 * jitter()});
    for (int i = 0; i < along; ++i)
      for (int j = 0; j < along; ++j)
        named.cloud.positions.push_back({150.0 + 0.1 * jitter(), i + jitter(), j + jitter()});
    put_in_order(named.cloud);
    return run(job_without_fill(scratch, named));
  };
  const std::string what = "the side of the normals is a guess on ";
  const auto tells = [&](const std::vector<std::string>& texts) {
    return std::ranges::any_of(
        texts, [&](const std::string& text) { return text.find(what) != std::string::npos; });
  };
  const RunReport small = boards_of(18), large = boards_of(40), none = boards_of(0);
  CHECK(tells(small.notes));
  CHECK_FALSE(tells(small.warnings));
  CHECK(tells(large.warnings));
  CHECK_FALSE(tells(none.notes));
}

TEST_CASE("NormalsThatAreNoneLeadToTheAdviceToEstimateThem") {
  ScratchDirectory scratch;
  const Job job = job_without_fill(scratch, sphere_with([](Vec3, Vec3) { return Vec3{0, 0, 0}; }));
  CHECK_THROWS_WITH(run(job), Contains("normals.source"));
}

TEST_CASE("APlaceOfTheScannerThatTurnsNoNormalsIsWarnedOf") {
  ScratchDirectory scratch;
  const std::string what = "decides nothing";
  Job job = job_without_fill(scratch, random_sphere(5000, 11));
  CHECK_FALSE(warns_of(job, what));
  job.normals.orientation = Orientation::kGround;
  CHECK_FALSE(warns_of(job, what));
  job.input.scanner = ScannerPlace{{4.0, 0.0, 0.0}, false};
  CHECK(warns_of(job, what));
  CHECK(doubts(job, what));
  job.normals.source = NormalSource::kEstimate;
  CHECK_FALSE(warns_of(job, what));
}
