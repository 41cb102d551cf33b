// Super Cocone: Cocone chunk by chunk, and what its chunks agree on.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <string>
#include <tuple>
#include <vector>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"
#include "tests/support/meshes.h"
#include "tests/support/sanitized.h"

namespace orbweave {
namespace {

using namespace test;

Job chunk_job(const ScratchDirectory& scratch, const NamedCloud& named, std::uint64_t points) {
  Job job = job_for(scratch, named);
  job.reconstruct.method = ReconstructionMethod::kSuperCocone;
  job.partition.chunk_points = points;
  return job;
}

using Places = std::array<Vec3, 3>;

bool comes_first(const Vec3& a, const Vec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Triangles by their corners' places, whatever the numbers of the vertices.
std::vector<std::array<double, 9>> triangles_by_place(const std::string& file) {
  const TriangleMesh mesh = read_mesh(file);
  std::vector<std::array<double, 9>> all;
  for (const Triangle& t : mesh.triangles) {
    Places p = {mesh.vertices.positions[t[0]], mesh.vertices.positions[t[1]],
                mesh.vertices.positions[t[2]]};
    std::sort(p.begin(), p.end(), comes_first);
    all.push_back({p[0].x, p[0].y, p[0].z, p[1].x, p[1].y, p[1].z, p[2].x, p[2].y, p[2].z});
  }
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

TEST_CASE("ASuperCoconeOfOneChunkIsTheCocone") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  const NamedCloud named = painted_torus(1500, 0.3, 3);
  Job job = chunk_job(scratch, named, 1'000'000);
  const RunReport report = run(job);
  CHECK(report.chunks == 1);
  const std::string expected = bytes_of(job.output.mesh);
  job.reconstruct.method = ReconstructionMethod::kCocone;
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("SuperCoconeClosesATorusOverItsSeams") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  const Job job = chunk_job(scratch, painted_torus(12'000, 0.05, 3), 1500);
  const RunReport report = run(job);
  CHECK(report.chunks > 8);
  CHECK(report.mesh.watertight);
  CHECK(report.mesh.euler_characteristic == 0);
  REQUIRE(report.voronoi);
  CHECK(report.voronoi->seam_triangles > 500);
  CHECK(report.voronoi->contested_triangles * 100 < report.voronoi->seam_triangles);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  CHECK(validate_mesh(mesh).empty());
  CHECK(mesh_facts(mesh).triangles == report.mesh.triangles);
  CHECK(mesh_facts(mesh).euler_characteristic == 0);
}

TEST_CASE("FlatChunksOfASuperCoconeHaveTheTrianglesOfTheirPlane") {
  if (!has_voronoi_family()) return;
  // The faces of a cube, each a plane of its own that holds whole chunks.
  constexpr int kSide = 40;
  NamedCloud cube{"cube", {}, 1.5};
  const auto is_end = [](int i) { return i == 0 || i == kSide - 1; };
  for (int x = 0; x < kSide; ++x)
    for (int y = 0; y < kSide; ++y)
      for (int z = 0; z < kSide; ++z)
        if (is_end(x) || is_end(y) || is_end(z))
          cube.cloud.positions.push_back({1.0 * x, 1.0 * y, 1.0 * z});
  ScratchDirectory scratch, other;
  Job job = chunk_job(scratch, cube, 800);
  job.fill.enabled = false;
  CHECK(run(job).chunks > 8);
  Job whole = chunk_job(other, cube, 1'000'000);
  whole.fill.enabled = false;
  run(whole);
  CHECK((triangles_by_place(job.output.mesh) == triangles_by_place(whole.output.mesh)));
}

TEST_CASE("SuperCoconeAgreesWithCoconeUpToFewTriangles") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch, other;
  const NamedCloud named = painted_torus(12'000, 0.3, 3);
  Job job = chunk_job(scratch, named, 1500);
  job.fill.enabled = false;
  run(job);
  Job whole = chunk_job(other, named, 1'000'000);
  whole.fill.enabled = false;
  run(whole);
  const auto in_chunks = triangles_by_place(job.output.mesh);
  const auto at_once = triangles_by_place(whole.output.mesh);
  std::vector<std::array<double, 9>> different;
  std::set_symmetric_difference(in_chunks.begin(), in_chunks.end(), at_once.begin(), at_once.end(),
                                std::back_inserter(different));
  CHECK(different.size() * 30 < at_once.size());
}

TEST_CASE("OneCutOfSuperCoconeMakesTheSameBytesForAnyThreadsAndOrder", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  NamedCloud named = painted_torus(6000, 0.5, 3);
  Job job = chunk_job(scratch, named, 1500);
  job.run.threads = 1;
  const std::string expected = mesh_bytes(job);
  job.run.threads = 3;
  CHECK((mesh_bytes(job) == expected));
  shuffle(named.cloud, 7);
  write_cloud(job.input.files.front(), named.cloud);
  CHECK((mesh_bytes(job) == expected));
}

TEST_CASE("AnInterruptedSuperCoconeResumesToTheSameBytes", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  const Job job = chunk_job(scratch, painted_torus(3000, 0.3, 3), 800);
  const std::string expected = mesh_bytes(job);
  std::filesystem::remove(job.output.mesh);
  CHECK(run_with_interruptions(job, 1, 7) > 0);
  CHECK((bytes_of(job.output.mesh) == expected));
}

TEST_CASE("EveryEdgeOfASuperCoconeHasAtMostTwoTriangles") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = chunk_job(scratch, painted_torus(8000, 1.5, 3), 1000);
  job.fill.enabled = false;
  const RunReport report = run(job);
  CHECK(report.chunks > 4);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  CHECK(validate_mesh(mesh).empty());
  CHECK(mesh_facts(mesh).nonmanifold_edges == 0);
  CHECK(mesh_facts(mesh).boundary_edges == report.mesh.boundary_edges);
}

TEST_CASE("CellsAreCertainWhereTheBoxReachesAroundTheShape") {
  if (!has_voronoi_family()) return;
  const NamedCloud named = painted_torus(3000, 0.2, 3);
  const Box all = named.cloud.bounds();
  const CoconeOfPart whole = cocone_of_part(named.cloud.positions, {}, all, all, nullptr);
  CHECK(std::count(whole.certified.begin(), whole.certified.end(), 0) == 0);
  // Half of the torus: what lies far from the cut is known, what lies at the cut is not.
  Box half = all;
  half.max.x = 0.0;
  std::vector<Vec3> points;
  for (const Vec3 p : named.cloud.positions)
    if (half.contains(p)) points.push_back(p);
  const CoconeOfPart part = cocone_of_part(points, {}, half, all, nullptr);
  std::size_t certified_at_cut = 0, certified_far = 0, far = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points[i].x > -0.05) certified_at_cut += part.certified[i];
    if (points[i].x < -0.9) ++far, certified_far += part.certified[i];
  }
  CHECK(certified_at_cut == 0);
  REQUIRE(far > 100);
  CHECK(certified_far > 0);
}

TEST_CASE("ACoconeBeyondTheBudgetGoesInChunksAndSaysSo", "[costly]") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(200'000, 0.0, 1));
  job.reconstruct.method = ReconstructionMethod::kCocone;
  job.run.threads = 1;
  job.partition.memory_bytes = std::uint64_t{256} << 20;
  const RunReport report = run(job);
  CHECK(report.chunks > 1);
  CHECK(report.mesh.watertight);
  CHECK(report.mesh.euler_characteristic == 0);
  // The address sanitizer holds freed memory back and keeps notes of the rest.
  if (!test::kIsSanitized) CHECK(report.peak_memory_bytes < job.partition.memory_bytes);
  CHECK(std::any_of(report.notes.begin(), report.notes.end(), [](const std::string& note) {
    return note.find("the mesh depends on the chunks") != std::string::npos;
  }));
}

}  // namespace orbweave
