// The hole pass of a job: wherever the holes lie relative to the chunks.
#include "engine/pipeline/surface/hole_stage.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <utility>

#include "engine/planning/plan_job.h"
#include "engine/validation/mesh_crossings.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

using test::bytes_of;
using test::job_for;
using test::mesh_bytes;
using test::NamedCloud;
using test::run;
using test::ScratchDirectory;

void remove_ball(PointCloud& cloud, Vec3 center, double radius) {
  PointCloud kept;
  kept.schema = cloud.schema;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (norm(cloud.positions[i] - center) >= radius) kept.append(cloud, i);
  }
  cloud = std::move(kept);
}

/// A torus with a hole and so much noise that patches run into the surface and sheets touch.
NamedCloud crumpled_torus() {
  NamedCloud named = test::painted_torus(4000, 2.0, 34);
  remove_ball(named.cloud, {1.0, 0.0, 0.4}, 0.3);
  return named;
}

/// What lies above: an open shell.
NamedCloud half_of(NamedCloud named) {
  PointCloud kept;
  kept.schema = named.cloud.schema;
  for (std::size_t i = 0; i < named.cloud.size(); ++i)
    if (named.cloud.positions[i].z > -0.1) kept.append(named.cloud, i);
  named.cloud = std::move(kept);
  return named;
}

/// A sphere with holes from a few edges to a fifth of the surface.
NamedCloud punched_sphere() {
  NamedCloud named = test::random_sphere(9000, 31);
  named.ball_radius *= 1.3;
  remove_ball(named.cloud, {1.0, 0.0, 0.0}, 0.25);
  remove_ball(named.cloud, {0.0, 0.707, 0.707}, 0.2);
  remove_ball(named.cloud, {-0.577, -0.577, 0.577}, 0.9);
  remove_ball(named.cloud, {0.3, -0.3, -0.9}, 0.15);
  test::paint(named.cloud);
  return named;
}

}  // namespace

TEST_CASE("SameBytesWithHolesAcrossTwoToEightChunks", "[slow]") {
  const NamedCloud named = punched_sphere();
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 1'000'000'000;
  const std::string expected = mesh_bytes(job);
  std::set<std::size_t> chunks_of_a_hole;
  for (const auto& [chunk_points, threads] :
       {std::pair{250, 5}, std::pair{700, 1}, std::pair{700, 2}, std::pair{2000, 5},
        std::pair{4000, 2}}) {
    job.partition.chunk_points = static_cast<std::uint64_t>(chunk_points);
    job.run.threads = threads;
    INFO("chunk_points " << chunk_points << ", threads " << threads);
    const RunReport report = run(job);
    REQUIRE((bytes_of(job.output.mesh) == expected));
    for (const HoleFacts& hole : report.holes) chunks_of_a_hole.insert(hole.chunks.size());
  }
  for (const std::size_t chunks : {1u, 2u, 3u, 4u}) CHECK(chunks_of_a_hole.count(chunks) == 1);
  CHECK(*chunks_of_a_hole.rbegin() >= 8);
}

TEST_CASE("CrumpledHolesAreFilledWithoutACrossingInAnyCut", "[costly]") {
  // Half of it: an object seen from all around would be mended.
  const NamedCloud named = half_of(crumpled_torus());
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 1'000'000'000;
  job.output.check_surface = true;
  const RunReport whole = run(job);
  const std::string expected = bytes_of(job.output.mesh);
  CHECK(whole.mesh.patch_crossing_pairs == 0);
  CHECK(whole.mesh.crossing_pairs == count_crossing_pairs(read_mesh(job.output.mesh)));
  CHECK(std::any_of(whole.holes.begin(), whole.holes.end(),
                    [](const HoleFacts& hole) { return hole.filled && hole.open_edges > 0; }));
  CHECK(whole.mesh.mended_triangles > 0);  // flaps at rims
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  REQUIRE(validate_mesh(mesh).empty());
  const MeshFacts measured = mesh_facts(mesh);
  CHECK(whole.mesh.vertices == measured.vertices);
  CHECK(whole.mesh.triangles == measured.triangles);
  CHECK(whole.mesh.components == measured.components);
  CHECK(whole.mesh.boundary_edges == measured.boundary_edges);
  CHECK(whole.mesh.boundary_loops == measured.boundary_loops);
  CHECK(whole.mesh.area == Approx(measured.area).epsilon(1e-9));
  CHECK(measured.unreferenced_vertices == 0);
  for (const auto& [chunk_points, threads] :
       {std::pair{300, 2}, std::pair{1000, 1}, std::pair{2500, 5}}) {
    job.partition.chunk_points = static_cast<std::uint64_t>(chunk_points);
    job.run.threads = threads;
    INFO("chunk_points " << chunk_points << ", threads " << threads);
    const RunReport report = run(job);
    CHECK((bytes_of(job.output.mesh) == expected));
    CHECK(report.mesh.crossing_pairs == whole.mesh.crossing_pairs);
    CHECK(report.mesh.patch_crossing_pairs == 0);
  }
  job.fill.allow_intersections = true;
  const RunReport crossing = run(job);
  CHECK(*crossing.mesh.patch_crossing_pairs > 0);
  CHECK(crossing.mesh.crossing_pairs == count_crossing_pairs(read_mesh(job.output.mesh)));
  job.fill.enabled = false;
  const RunReport open = run(job);
  CHECK(open.mesh.crossing_pairs == count_crossing_pairs(read_mesh(job.output.mesh)));
}

TEST_CASE("WhatKeepsAWideShadowOpenIsToldByTheJob") {
  // A floor of 100 by 100 steps, of which a box hides 38 by 38 beside it: a ramp to its lid would
  // be a guess.
  NamedCloud named{"floor", {}, 1.1};
  named.cloud.schema.has_normals = true;
  for (int x = 0; x < 100; ++x) {
    for (int y = 0; y < 100; ++y) {
      const bool is_beside = std::abs(y - 50) < 19;
      if (is_beside && x > 11 && x < 50) continue;
      const bool is_on_box = is_beside && x >= 50 && x < 85;
      named.cloud.positions.push_back({double(x), double(y), is_on_box ? 1.0 : 0.0});
      named.cloud.normals.push_back({0.0, 0.0, 1.0});
    }
  }
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  for (const std::uint64_t chunk_points : {1'000'000u, 2'000u}) {
    job.partition.chunk_points = chunk_points;
    const RunReport report = run(job);
    const auto wide =
        std::find_if(report.holes.begin(), report.holes.end(),
                     [](const HoleFacts& h) { return h.open == OpenReason::kTooWide; });
    REQUIRE(wide != report.holes.end());
    CHECK_FALSE(wide->filled);
    CHECK(wide->reason.find("guess") != std::string::npos);
  }
}

TEST_CASE("FactsOfAFilledMeshAreThoseOfItsFile", "[costly]") {
  for (const double noise : {0.0, 0.6, 0.9}) {
    for (const bool keep_border : {true, false}) {
      NamedCloud named = test::painted_torus(3000, noise, 33);
      remove_ball(named.cloud, {1.0, 0.0, 0.4}, 0.3);
      ScratchDirectory scratch;
      Job job = job_for(scratch, named);
      job.partition.chunk_points = 500;
      job.fill.keep_outer_border = keep_border;
      job.fill.min_triangles = noise > 0.8 ? 6 : 0;
      const RunReport report = run(job);
      const MeshFacts& told = report.mesh;
      const TriangleMesh mesh = read_mesh(job.output.mesh);
      INFO("noise " << noise << ", border " << keep_border);
      REQUIRE(validate_mesh(mesh).empty());
      const MeshFacts measured = mesh_facts(mesh);
      CHECK(told.vertices == measured.vertices);
      CHECK(told.triangles == measured.triangles);
      CHECK(told.components == measured.components);
      CHECK(told.boundary_edges == measured.boundary_edges);
      CHECK(told.boundary_loops == measured.boundary_loops);
      CHECK(measured.nonmanifold_edges == 0);
      CHECK(measured.nonmanifold_vertices == 0);
      CHECK(told.nonmanifold_vertices == 0);
      CHECK(told.euler_characteristic == measured.euler_characteristic);
      CHECK(told.watertight == measured.watertight);
      CHECK(told.checksum == measured.checksum);
      CHECK(told.area == Approx(measured.area).epsilon(1e-9));
      CHECK(told.patch_area == Approx(measured.patch_area).epsilon(1e-9));
      double of_holes = 0.0;
      for (const HoleFacts& hole : report.holes) {
        of_holes += hole.area;
        CHECK((hole.confidence > 0.0) == hole.filled);
        CHECK(hole.confidence <= 1.0);
        CHECK(hole.rim_mean_deg <= hole.rim_dihedral_deg);
      }
      CHECK(told.patch_area == Approx(of_holes).epsilon(1e-9));
      CHECK(measured.unreferenced_vertices == 0);
      std::uint64_t added = 0;
      for (const HoleFacts& hole : report.holes) added += hole.triangles_added;
      CHECK(std::count_if(mesh.hole.begin(), mesh.hole.end(), [](auto id) { return id != 0; }) ==
            static_cast<std::ptrdiff_t>(added));
    }
  }
}

TEST_CASE("AMendedObjectIsWatertightAndHasTheSameBytesInAnyCut", "[costly]") {
  const NamedCloud named = crumpled_torus();
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 1'000'000'000;
  job.output.check_surface = true;
  const RunReport whole = run(job);
  const std::string expected = bytes_of(job.output.mesh);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  REQUIRE(validate_mesh(mesh).empty());
  CHECK(whole.mesh.mended_triangles > 0);
  CHECK(whole.mesh.mended_triangles < whole.mesh.triangles / 20);
  CHECK(whole.mesh.crossing_pairs == count_crossing_pairs(mesh));
  CHECK(whole.mesh.patch_crossing_pairs == 0);
  CHECK(whole.mesh.watertight);
  CHECK(whole.mesh.pinches == 0);
  const MeshFacts measured = mesh_facts(mesh);
  CHECK(measured.watertight);
  CHECK(measured.components == whole.mesh.components);
  CHECK(measured.vertices == whole.mesh.vertices);
  CHECK(measured.unreferenced_vertices == 0);
  CHECK(measured.area == Approx(whole.mesh.area).epsilon(1e-9));
  CHECK(measured.patch_area == Approx(whole.mesh.patch_area).epsilon(1e-9));
  for (const auto& [chunk_points, threads] :
       {std::pair{300, 2}, std::pair{1000, 1}, std::pair{2500, 5}}) {
    job.partition.chunk_points = static_cast<std::uint64_t>(chunk_points);
    job.run.threads = threads;
    INFO("chunk_points " << chunk_points << ", threads " << threads);
    const RunReport report = run(job);
    CHECK((bytes_of(job.output.mesh) == expected));
    CHECK(report.mesh.mended_triangles == whole.mesh.mended_triangles);
    CHECK(report.mesh.boundary_edges == whole.mesh.boundary_edges);
  }
}

TEST_CASE("CrumbsBesideASurfaceGoAndAreCounted") {
  NamedCloud named = test::painted_torus(3000, 0.0, 36);
  // Three points of their own: a triangle, far from the rest.
  for (const Vec3 offset : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}) {
    named.cloud.append(named.cloud, 0);
    named.cloud.positions.back() = Vec3{3.0, 0.0, 0.0} + named.ball_radius * offset;
    named.cloud.normals.back() = {0.0, 0.0, 1.0};
  }
  const Vec3 beside = named.cloud.positions.back() + Vec3{named.ball_radius, 0, 0};
  named.cloud.append(named.cloud, named.cloud.size() - 1);
  named.cloud.positions.back() = beside;
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 500;
  const RunReport without = run(job);
  CHECK(without.pieces_removed == 1);
  CHECK(without.triangles_removed == 2);
  CHECK(without.mesh.watertight);
  CHECK(without.mesh.components == 1);
  job.fill.min_triangles = 0;
  const RunReport with = run(job);
  CHECK(with.pieces_removed == 0);
  CHECK(with.mesh.components == 2);
  CHECK(with.mesh.boundary_edges == 4);
  CHECK(with.mesh.triangles == without.mesh.triangles + 2);
}

TEST_CASE("AMeshWithoutTrianglesHasNoArea") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, test::noisy_torus(2000, 0.1, 7));
  job.partition.chunk_points = 300;
  job.fill.min_triangles = 1'000'000;
  const RunReport report = run(job);
  CHECK(report.mesh.triangles == 0);
  CHECK(report.mesh.area == 0.0);
}

TEST_CASE("NewVerticesGetColoursFromAroundTheHole") {
  NamedCloud named = test::painted_torus(6000, 0.0, 35);
  remove_ball(named.cloud, {1.0, 0.0, 0.4}, 0.25);
  ScratchDirectory scratch;
  const Job job = job_for(scratch, named);
  const RunReport report = run(job);
  REQUIRE(report.mesh.watertight);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  REQUIRE(mesh.vertices.size() > named.cloud.size() + 10);
  PointCloud expected = mesh.vertices;
  expected.attributes.clear();
  test::paint(expected);
  for (std::size_t v = named.cloud.size(); v < mesh.vertices.size(); ++v) {
    CHECK(attribute_value(mesh.vertices, v, 0) ==
          Approx(attribute_value(expected, v, 0)).margin(3.0));
    CHECK(attribute_value(mesh.vertices, v, 1) ==
          Approx(attribute_value(expected, v, 1)).margin(0.02));
    CHECK(norm(mesh.vertices.normals[v]) == Approx(1.0).margin(1e-5));
  }
}

TEST_CASE("WithoutTheFillTheMeshHasNoPatches") {
  const NamedCloud named = punched_sphere();
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.fill.enabled = false;
  const RunReport report = run(job);
  CHECK(report.holes.empty());
  CHECK(report.mesh.boundary_loops >= 4);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  CHECK(mesh.hole.empty());
  CHECK(mesh.vertices.size() <= named.cloud.size());
}

TEST_CASE("InterruptedInTheHolePassAndResumedGivesTheSameBytes", "[slow]") {
  NamedCloud named = test::painted_torus(4000, 0.7, 37);
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.partition.chunk_points = 300;
  job.run.threads = 2;
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  class StopInHoles : public test::RecordingProgress {
   public:
    StopToken* stop = nullptr;
    int steps = 0;
    std::atomic<int> seen{0};
    std::atomic<bool> in_holes{false};
    void begin_stage(const std::string& name, std::uint64_t, const std::string&) override {
      in_holes = name == "holes";
    }
    void advance(std::uint64_t) override {
      if (in_holes && ++seen == steps) stop->request();
    }
  };
  int interruptions = 0;
  for (int steps = 1; steps < 60; steps += 9) {
    StopToken stop;
    StopInHoles progress;
    progress.stop = &stop;
    progress.steps = steps;
    try {
      run_job(job, {"test"}, progress, stop);
      break;
    } catch (const Error& error) {
      REQUIRE(error.kind() == ErrorKind::kInterrupted);
      ++interruptions;
    }
  }
  CHECK(interruptions > 0);
  if (!std::filesystem::exists(job.output.mesh)) run(job);
  REQUIRE((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("ADamagedPatchIsComputedAgain", "[costly]") {
  const NamedCloud named = punched_sphere();
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.run.keep_work_dir = true;
  const std::string expected = mesh_bytes(job);
  const auto victim = std::filesystem::path(job.run.work_dir) / kHoleStage / "000000.h5";
  REQUIRE(std::filesystem::exists(victim));
  test::damage(victim);
  REQUIRE((mesh_bytes(job) == expected));
}

TEST_CASE("WhatIsComputedAgainIsSaidOnce") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, punched_sphere());
  job.run.keep_work_dir = true;
  run(job);
  test::damage(std::filesystem::path(job.run.work_dir) / kHoleStage / "000000.h5");
  std::vector<std::string> notes = run(job).notes;
  CHECK(std::ranges::any_of(notes, [](const std::string& note) {
    return note.find("computing it again") != std::string::npos;
  }));
  CHECK(std::ranges::any_of(
      notes, [](const std::string& note) { return note.starts_with("ball radii: "); }));
  std::ranges::sort(notes);
  CHECK(std::ranges::adjacent_find(notes) == notes.end());
}

TEST_CASE("ChangedFillOptionsComputeThePatchesAnewButNotTheMesh") {
  const NamedCloud named = punched_sphere();
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.run.keep_work_dir = true;
  const RunReport first = run(job);
  job.fill.max_edges = 20;
  const RunReport second = run(job);
  const auto stage = [](const RunReport& report, const std::string& name) {
    const auto at = std::find_if(report.stages.begin(), report.stages.end(),
                                 [&](const StageFacts& facts) { return facts.name == name; });
    REQUIRE(at != report.stages.end());
    return *at;
  };
  CHECK(stage(second, "reconstruct").chunks_reused == stage(first, "reconstruct").chunks);
  CHECK(stage(second, "holes").chunks_reused == 0);
  CHECK(second.mesh.boundary_loops > first.mesh.boundary_loops);
}

TEST_CASE("PlanListsTheLoopsOfAMeshThatIsThereAlready", "[costly]") {
  const NamedCloud named = punched_sphere();
  ScratchDirectory scratch;
  Job job = job_for(scratch, named);
  job.run.keep_work_dir = true;
  job.fill.max_edges = 20;
  test::RecordingProgress progress;
  const StopToken stop;
  REQUIRE_FALSE(plan_job(job, progress, stop).loops.has_value());
  const RunReport report = run(job);
  const JobPlan plan = plan_job(job, progress, stop);
  REQUIRE(plan.loops.has_value());
  REQUIRE(plan.loops->size() == report.holes.size());
  for (std::size_t l = 0; l < plan.loops->size(); ++l) {
    const HoleFacts &planned = (*plan.loops)[l], &done = report.holes[l];
    CHECK(planned.first_vertex == done.first_vertex);
    CHECK(planned.edges == done.edges);
    CHECK(planned.reason.empty() == done.filled);
  }
  job.reconstruct.ball_radii = {2.0 * named.ball_radius};
  CHECK_FALSE(plan_job(job, progress, stop).loops.has_value());
}

}  // namespace orbweave
