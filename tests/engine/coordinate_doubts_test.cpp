// Coordinates, units and poses that are in doubt: runs, plans and inspections say so.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "engine/planning/plan_job.h"
#include "engine/reconstruct.h"
#include "engine/spacing/coordinate_decades.h"
#include "engine/spacing/coordinate_step.h"
#include "engine/validation/cloud_facts.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/text/quantity.h"
#include "tests/engine/doubts.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/program.h"
#include "tests/support/raw_scans.h"

using Catch::Matchers::Contains;
using namespace orbweave;
using namespace orbweave::test;

namespace {

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
