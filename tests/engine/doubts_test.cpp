// Where the result of a run is in doubt, the run says so, and nothing that is not true.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/planning/plan_job.h"
#include "engine/reconstruct.h"
#include "engine/spacing/coordinate_decades.h"
#include "engine/spacing/coordinate_step.h"
#include "engine/validation/cloud_facts.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/text/quantity.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"
#include "tests/support/raw_scans.h"

using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using namespace orbweave;
using namespace orbweave::test;

namespace {

[[maybe_unused]] const bool in_memory = scratch_in_memory();

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

/// Whether a plan says so beforehand.
bool doubts(const Job& job, const std::string& words) {
  RecordingProgress progress;
  const StopToken stop;
  const std::vector<std::string> all = plan_job(job, progress, stop).doubts;
  return std::ranges::any_of(
      all, [&](const std::string& doubt) { return doubt.find(words) != std::string::npos; });
}

/// A sheet of points 0.05 apart, neither on a lattice nor in a row.
NamedCloud uneven_sheet(Vec3 corner) {
  Random random(5);
  NamedCloud named;
  named.ball_radius = 0.07;
  named.cloud.schema.has_normals = true;
  for (int i = 0; i < 3600; ++i) {
    const Vec3 place{0.05 * (i % 60) + 0.02 * random.uniform(),
                     0.05 * (i / 60) + 0.02 * random.uniform(), 0.001 * random.uniform()};
    named.cloud.positions.push_back(corner + place);
    named.cloud.normals.push_back({0, 0, 1});
  }
  put_in_order(named.cloud);
  return named;
}

PointCloud as_floats(PointCloud cloud) {
  for (Vec3& p : cloud.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<double>(static_cast<float>(p[axis]));
  put_in_order(cloud);
  return cloud;
}

/// A torus whose coordinates are whole steps from an offset, as LAS files store them.
NamedCloud torus_in_steps(double step, Vec3 offset = {}) {
  NamedCloud torus = noisy_torus(4000, 0.0, 3);
  for (Vec3& p : torus.cloud.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] / step) * step + offset[axis];
  put_in_order(torus.cloud);
  return torus;
}

double common_step_of(const PointCloud& cloud) {
  const SpacingSite site{cloud.bounds(), cloud.bounds(), cloud.positions};
  return common_step({&site, 1});
}

/// The two sides of a plate, exact, a number of grid steps apart.
NamedCloud thin_plate(double steps) {
  NamedCloud named;
  named.ball_radius = 1.1;
  named.cloud.schema.has_normals = true;
  for (int i = 0; i < 60; ++i)
    for (int j = 0; j < 60; ++j)
      for (const double side : {-1.0, 1.0}) {
        named.cloud.positions.push_back({1.0 * i, 1.0 * j, 0.5 * side * steps});
        named.cloud.normals.push_back({0, 0, side});
      }
  put_in_order(named.cloud);
  return named;
}

/// Points whose coordinates have magnitudes all through so many decades around 1.
NamedCloud spread_over(double decades, std::size_t points) {
  Random random(7);
  NamedCloud named;
  named.ball_radius = 1.0;
  named.cloud.schema.has_normals = true;
  const auto coordinate = [&] {
    const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
    return sign * std::pow(10.0, decades * (random.uniform() - 0.5));
  };
  for (std::size_t i = 0; i < points; ++i) {
    const double x = coordinate(), y = coordinate();
    named.cloud.positions.push_back({x, y, coordinate()});
    named.cloud.normals.push_back({0, 0, 1});
  }
  put_in_order(named.cloud);
  return named;
}

int crowded_decades(const PointCloud& cloud) {
  const SpacingSite site{cloud.bounds(), cloud.bounds(), cloud.positions};
  return coordinate_decades({&site, 1}).crowded;
}

/// An even sphere whose normals `change` turns.
NamedCloud sphere_with(const std::function<Vec3(Vec3 place, Vec3 normal)>& change) {
  NamedCloud named = random_sphere(12000, 11);
  for (std::size_t i = 0; i < named.cloud.size(); ++i)
    named.cloud.normals[i] = change(named.cloud.positions[i], named.cloud.normals[i]);
  return named;
}

/// What reading and cleaning `job` says when it is interrupted at a stage and resumed.
RunReport resumed_at(const Job& job, const std::string& stage) {
  StopToken stop;
  RecordingProgress progress;
  progress.at_stage = [&](const std::string& begun) {
    if (begun == stage) stop.request();
  };
  try {
    run_job(job, {"test"}, progress, stop);
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kInterrupted);
  }
  return run(job);
}

std::vector<std::string> without_resuming(std::vector<std::string> notes) {
  std::erase_if(notes, [](const std::string& note) { return note.starts_with("resuming"); });
  return notes;
}

/// Positions as an .xyz file, multiplied and then moved.
std::string scan_file(const ScratchDirectory& scratch, const std::string& name,
                      const NamedCloud& named, double factor, Vec3 move = {}) {
  std::string text;
  for (const Vec3& p : named.cloud.positions) {
    const Vec3 q = factor * p + move;
    text += format_exact(q.x) + " " + format_exact(q.y) + " " + format_exact(q.z) + "\n";
  }
  const std::filesystem::path file = scratch.path() / name;
  write_text(file, text);
  return file.string();
}

/// A job on several files that hold no normals.
Job job_of_files(const ScratchDirectory& scratch, const std::vector<std::string>& files) {
  Job job = job_for(scratch, uneven_sheet({}), files);
  job.normals.source = NormalSource::kEstimate;
  job.reconstruct.ball_radii.clear();
  job.fill.enabled = false;
  return job;
}

/// The lines of a file of poses, which begin with "bmesh", one per scan.
std::vector<std::string> pose_lines(const std::string& file) {
  std::vector<std::string> lines;
  std::istringstream text(bytes_of(file));
  for (std::string line; std::getline(text, line);)
    if (line.starts_with("bmesh")) lines.push_back(line);
  return lines;
}

/// What follows the name of the scan.
std::string pose_in(const std::string& line) { return line.substr(line.find(' ', 6)); }

/// The pose, moved.
std::string moved_pose(const std::string& pose, Vec3 by) {
  std::istringstream words(pose);
  Vec3 t;
  words >> t.x >> t.y >> t.z;
  std::string turn;
  std::getline(words, turn);
  t = t + by;
  return " " + format_exact(t.x) + " " + format_exact(t.y) + " " + format_exact(t.z) + turn;
}

void write_poses(const std::string& file, const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  write_text(file, text);
}

std::vector<std::string> off_surface(const std::vector<std::string>& warnings) {
  std::vector<std::string> some;
  for (const std::string& warning : warnings)
    if (warning.find("does not lie on the surface") != std::string::npos) some.push_back(warning);
  return some;
}

double step_of(const PointCloud& cloud) {
  const SpacingSite site{cloud.bounds(), cloud.bounds(), cloud.positions};
  return coordinate_step({&site, 1});
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

TEST_CASE("DegreesBesideHeightsAreWarnedOf") {
  ScratchDirectory scratch;
  NamedCloud named = uneven_sheet({});
  for (Vec3& p : named.cloud.positions)  // 3 m wide, 2 m high
    p = {8.5 + 1.3e-5 * p.x, 47.3 + 9e-6 * p.y, 400.0 + std::sin(2.0 * p.x)};
  put_in_order(named.cloud);
  CHECK(warns_of(job_without_fill(scratch, named), "look like degrees of longitude"));
  CHECK(doubts(job_without_fill(scratch, named), "look like degrees of longitude"));
  // A tower is high, too.
  NamedCloud tower = uneven_sheet({});
  for (Vec3& p : tower.cloud.positions) p = {8.5 + 0.1 * p.x, 47.3 + 0.001 * p.z, 10.0 * p.y};
  put_in_order(tower.cloud);
  CHECK_FALSE(warns_of(job_without_fill(scratch, tower), "degrees"));
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

TEST_CASE("TheStepOfCoordinatesIsThatOfFloatsTheyWereRoundedTo") {
  const Vec3 map{3.0e5, 4.2e6, 100.0};
  const NamedCloud sheet = uneven_sheet(map);
  CHECK(step_of(sheet.cloud) == 0.0);
  CHECK(step_of(as_floats(sheet.cloud)) == 0.5);
  CHECK(step_of(as_floats(uneven_sheet({}).cloud)) < 1e-6);
  // Whole metres and voxels are no rounded floats.
  NamedCloud grid = grid_sheet(40, 0.0);
  for (Vec3& p : grid.cloud.positions) p = {std::round(p.x) + 3e5, std::round(p.y) + 4.2e6, 7.0};
  CHECK(step_of(grid.cloud) == 0.0);
  CHECK(step_of({}) == 0.0);
}

TEST_CASE("CoordinatesInCoarseStepsAreWarnedOf") {
  ScratchDirectory scratch;
  NamedCloud sheet = uneven_sheet({3.0e5, 1.0e6, 100.0});
  Job job = job_without_fill(scratch, sheet);
  CHECK_FALSE(warns_of(job, "coordinates come in steps"));
  sheet.cloud = as_floats(sheet.cloud);
  job = job_without_fill(scratch, sheet);
  CHECK(warns_of(job, "coordinates come in steps of about 0.0625, the points lie "));
  job.normals.source = NormalSource::kEstimate;
  CHECK(warns_of(job, ": export them as doubles, or with an offset"));
  RecordingProgress progress;
  const StopToken stop;
  const JobPlan plan = plan_job(job, progress, stop);
  REQUIRE(plan.doubts.size() == 1);
  CHECK_THAT(plan.doubts.front(), Contains("coordinates come in steps of about 0.0625"));
}

TEST_CASE("TheCommonStepIsThatOfDecimalsAndScales") {
  const Vec3 map{515396.0, 4918348.0, 2324.0};
  for (const double step : {0.01, 0.05, 0.003048}) {
    CHECK(common_step_of(torus_in_steps(step).cloud) == Approx(step));
    CHECK(common_step_of(torus_in_steps(step, map).cloud) == Approx(step).epsilon(1e-3));
  }
  CHECK(common_step_of(as_floats(torus_in_steps(0.05).cloud)) == Approx(0.05).epsilon(1e-3));
  NamedCloud fine = random_sphere(4000, 11);
  for (Vec3& p : fine.cloud.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] / 0.00025) * 0.00025;
  put_in_order(fine.cloud);
  CHECK(common_step_of(fine.cloud) == Approx(0.00025));
  // Neither the places of floats nor one axis alone nor a few points tell of a step.
  CHECK(common_step_of(noisy_torus(4000, 0.0, 3).cloud) == 0.0);
  CHECK(common_step_of(as_floats(noisy_torus(4000, 0.0, 3).cloud)) == 0.0);
  NamedCloud terraces = noisy_torus(4000, 0.0, 3);
  for (Vec3& p : terraces.cloud.positions) p.z = std::round(p.z / 0.05) * 0.05;
  put_in_order(terraces.cloud);
  CHECK(common_step_of(terraces.cloud) == 0.0);
  PointCloud cube;
  for (int i = 0; i < 8; ++i)
    cube.positions.push_back(Vec3{1.0 * (i & 1), 0.5 * (i & 2), 0.25 * (i & 4)});
  CHECK(common_step_of(cube) == 0.0);
  CHECK(common_step_of({}) == 0.0);
}

TEST_CASE("CoordinatesOfFewDecimalsAreWarnedOfWhereTheStepsAreCoarse") {
  const std::string kDoubt = "coordinates on all axes come in steps of 0.02, the points lie ";
  const std::string kAdvice =
      "export them in finer steps (more decimals, a smaller scale of LAS), or thin them: "
      "cleaning.thin_to_spacing = 0.1";
  ScratchDirectory scratch;
  for (const NormalSource source : {NormalSource::kFile, NormalSource::kEstimate}) {
    Job job = job_without_fill(scratch, torus_in_steps(0.02));
    job.normals.source = source;
    CHECK(warns_of(job, kDoubt));
    CHECK(warns_of(job, kAdvice));
    CHECK(doubts(job, kDoubt));
    CHECK(doubts(job, kAdvice));
    job.cleaning.thin_to_spacing = 0.1;
    CHECK_FALSE(warns_of(job, "come in steps"));
    CHECK_FALSE(doubts(job, "come in steps"));
  }
  const auto fine = job_without_fill(scratch, torus_in_steps(0.002));
  CHECK_FALSE(warns_of(fine, "come in steps"));
  CHECK_FALSE(doubts(fine, "come in steps"));
}

TEST_CASE("InspectTellsOfCoordinatesOfFewDecimals") {
  ScratchDirectory scratch;
  const std::string file = scan_file(scratch, "coarse.xyz", torus_in_steps(0.02), 1.0);
  const auto source = open_point_source(file), again = open_point_source(file);
  const CloudFacts facts = cloud_facts(*source, again.get());
  CHECK(facts.common_step == Approx(0.02));
  CHECK_THAT(facts.doubt, Contains("coordinates on all axes come in steps of 0.02, the points"));
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

TEST_CASE("PosesBesideScansThatAreTakenWithoutThemAreNamed") {
  ScratchDirectory scratch;
  const NamedCloud torus = noisy_torus(4000, 0.0, 3);
  const std::vector<std::string> files = {(scratch / "a.ply").string(),
                                          (scratch / "b.ply").string()};
  for (const std::string& file : files) write_cloud(file, torus.cloud);
  Job job = job_without_fill(scratch, torus);
  job.input.files = files;
  write_text(scratch / "other.conf", "bmesh c.ply 0 0 0 0 0 0 1\n");
  CHECK_FALSE(warns_of(job, "poses"));
  write_text(scratch / "scans.conf", "bmesh a.ply 0 0 0 0 0 0 1\nbmesh b.ply 0 0 0 0 0 0 1\n");
  CHECK(warns_of(
      job, "scans.conf names a.ply: if the file holds their poses, give them by input.poses"));
  Job posed = job;
  posed.input.poses = (scratch / "scans.conf").string();
  CHECK_FALSE(warns_of(posed, "poses"));
  Job alone = job;
  alone.input.files.resize(1);
  CHECK_FALSE(warns_of(alone, "poses"));
  std::filesystem::remove(scratch / "scans.conf");
  write_text(scratch / "scans.aln", "1\nb.ply\n#\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n0\n");
  CHECK(warns_of(job,
                 "scans.aln names b.ply: if the file holds their poses, give them by input.pose"));
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

TEST_CASE("ScansHaveFewDecadesWhereverTheirStraysAre") {
  CHECK(crowded_decades(uneven_sheet({3.0e5, 1.0e6, 100.0}).cloud) == 1);
  CHECK(crowded_decades(uneven_sheet({0.0, 0.0, 0.0}).cloud) <= 2);
  PointCloud torus = noisy_torus(4000, 0.1, 3).cloud;
  for (std::size_t i = 0; i < 40; ++i)
    torus.positions[i] = {std::pow(10.0, static_cast<double>(i) - 20.0), 0.0, 0.0};
  torus.positions[40] = {0.0, 0.0, 0.0};
  CHECK(crowded_decades(torus) <= 2);
  CHECK(crowded_decades({}) == 0);
  CHECK(crowded_decades(spread_over(12.0, 4000).cloud) <= 12);
  CHECK(crowded_decades(spread_over(76.0, 4000).cloud) > 30);
}

TEST_CASE("CoordinatesOfAllDecadesAreRefusedBeforeTheirNeighboursAreSought") {
  ScratchDirectory scratch;
  const NamedCloud wide = spread_over(75.0, 60'000);
  Job job = job_without_fill(scratch, wide);
  job.normals.source = GENERATE(NormalSource::kEstimate, NormalSource::kFile);
  const std::string expected = "the byte order of the file, or the columns";
  RecordingProgress progress;
  const StopToken stop;
  const auto message = [](const auto& call) -> std::string {
    try {
      call();
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kBadInput);
      return error.what();
    }
    return "accepted";
  };
  for (const std::string& told :
       {message([&] { run(job); }), message([&] { plan_job(job, progress, stop); }),
        message([&] { reconstruct(wide.cloud); })})
    CHECK_THAT(told, Contains("coordinates span 7") && Contains(expected) &&
                         Contains("nine tenths of the points in "));
  CHECK_THAT(message([&] { run(job); }), Contains(job.input.files.front()));
  const auto source = open_point_source(job.input.files.front());
  const auto again = open_point_source(job.input.files.front());
  const CloudFacts facts = cloud_facts(*source, again.get());
  CHECK_THAT(facts.doubt, Contains("coordinates span 7") && Contains(expected));
  CHECK_FALSE(facts.spacing);
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

TEST_CASE("AScanInAnotherUnitIsWarnedOf") {
  const ScratchDirectory scratch;
  const NamedCloud sheet = uneven_sheet({1000, 2000, 3000});
  const std::string meters = scan_file(scratch, "meters.xyz", sheet, 1.0);
  const std::string beside = scan_file(scratch, "beside.xyz", sheet, 1.0, {2.5, 0, 0});
  const std::string millimeters = scan_file(scratch, "millimeters.xyz", sheet, 1000.0);
  const std::string kDoubt = "the unit is probably another one";
  CHECK_FALSE(warns_of(job_of_files(scratch, {meters, beside}), "unit"));
  CHECK(warns_of(job_of_files(scratch, {meters, millimeters, beside}), millimeters + " lies "));
  CHECK(warns_of(job_of_files(scratch, {meters, millimeters, beside}), kDoubt));
  // About the origin, where both lie on each other.
  const NamedCloud middle = uneven_sheet({-1.5, -1.5, 0});
  const std::string small = scan_file(scratch, "small.xyz", middle, 1.0);
  const std::string large = scan_file(scratch, "large.xyz", middle, 1000.0);
  CHECK(warns_of(job_of_files(scratch, {large, small}), large + " is "));
  RecordingProgress progress;
  const StopToken stop;
  const JobPlan plan = plan_job(job_of_files(scratch, {large, small}), progress, stop);
  REQUIRE(plan.doubts.size() == 1);
  CHECK_THAT(plan.doubts[0], Contains(kDoubt));
}

TEST_CASE("AnInterruptedRunWarnsOfUnitsAgain") {
  const ScratchDirectory scratch;
  const NamedCloud sheet = uneven_sheet({1, 2, 3});
  const Job job = job_of_files(scratch, {scan_file(scratch, "a.xyz", sheet, 1.0),
                                         scan_file(scratch, "b.xyz", sheet, 1000.0)});
  const std::vector<std::string> warnings = run(job).warnings;
  REQUIRE(warnings.size() >= 1);
  CHECK(resumed_at(job, "sort").warnings == warnings);
}

TEST_CASE("AScanWithAWrongPoseIsWarnedOf") {
  const ScratchDirectory scratch;
  const RawScans scans = scan_torus(scratch, 15000, 0.1, 0.2);
  Job job = job_for(scratch, scans);
  job.fill.enabled = false;
  CHECK(off_surface(run(job).warnings).empty());
  std::vector<std::string> lines = pose_lines(scans.poses);
  REQUIRE(lines.size() == 6);
  const std::string pose = pose_in(lines[2]);
  const double by = 10.0 * scans.spacing;
  lines[2] = lines[2].substr(0, lines[2].size() - pose.size()) +
             moved_pose(pose, {0.6 * by, 0.48 * by, 0.64 * by});
  write_poses(scans.poses, lines);
  const std::vector<std::string> warnings = off_surface(run(job).warnings);
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Matchers::StartsWith(scans.files[2] + " does not lie"));
  RecordingProgress progress;
  const StopToken stop;
  CHECK(off_surface(plan_job(job, progress, stop).doubts) == warnings);
  // The same numbers, however the job is cut, and after an interruption.
  job.partition.chunk_points = 4000;
  job.run.threads = 1;
  CHECK(off_surface(resumed_at(job, "sort").warnings) == warnings);
}

TEST_CASE("ScansWhosePosesAreSwappedAreWarnedOf") {
  const ScratchDirectory scratch;
  const RawScans scans = scan_torus(scratch, 15000, 0.1, 0.2);
  std::vector<std::string> lines = pose_lines(scans.poses);
  REQUIRE(lines.size() == 6);
  // A view from above, and one from a side.
  const std::string first = pose_in(lines[0]), third = pose_in(lines[2]);
  lines[0] = lines[0].substr(0, lines[0].size() - first.size()) + third;
  lines[2] = lines[2].substr(0, lines[2].size() - third.size()) + first;
  write_poses(scans.poses, lines);
  Job job = job_for(scratch, scans);
  job.fill.enabled = false;
  CHECK_FALSE(off_surface(run(job).warnings).empty());
}
