// Where a scan is too sparse for its shape: on the vertices, in the report and in the picture.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "engine/pipeline/surface/in_core_methods.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

using namespace test;

/// A torus without the points of half a right angle about z.
NamedCloud cut_torus(std::size_t points) {
  NamedCloud named = painted_torus(points, 0.02, 3);
  PointCloud kept;
  kept.schema = named.cloud.schema;
  for (std::size_t i = 0; i < named.cloud.size(); ++i) {
    const Vec3 p = named.cloud.positions[i];
    if (p.x < 0.0 || std::abs(p.y) > 0.4 * p.x) kept.append(named.cloud, i);
  }
  named.cloud = std::move(kept);
  return named;
}

bool is_near_cut(Vec3 p) { return p.x > 0.0 && std::abs(p.y) < 0.55 * p.x; }

/// The flag of a vertex; nothing without the column.
std::optional<std::uint8_t> flag_of(const PointCloud& vertices, std::size_t i) {
  std::size_t offset = 0;
  for (const AttributeField& field : vertices.schema.attributes) {
    if (field.name == "undersampled")
      return static_cast<std::uint8_t>(vertices.attribute_row(i)[offset]);
    offset += size_of(field.type);
  }
  return std::nullopt;
}

}  // namespace

TEST_CASE("VerticesSayWhereTheScanIsUndersampled") {
  if (!has_voronoi_family()) return;
  for (const ReconstructionMethod method :
       {ReconstructionMethod::kCocone, ReconstructionMethod::kTightCocone}) {
    ScratchDirectory scratch;
    Job job = job_for(scratch, cut_torus(6000));
    job.reconstruct.method = method;
    job.fill.keep_outer_border = false;
    job.output.vertex_undersampled = true;
    const RunReport report = run(job);
    const TriangleMesh mesh = read_mesh(job.output.mesh);
    std::uint64_t undersampled = 0, far_from_cut = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const auto flag = flag_of(mesh.vertices, i);
      REQUIRE(flag);
      if (*flag != 1) continue;
      ++undersampled;
      if (!is_near_cut(mesh.vertices.positions[i])) ++far_from_cut;
    }
    INFO("method " << static_cast<int>(method));
    CHECK(undersampled > 10);
    CHECK(far_from_cut == 0);
    REQUIRE(report.voronoi);
    CHECK(report.voronoi->undersampled_points >= undersampled);
    CHECK(report.voronoi->uncertified_points == 0);
  }
}

TEST_CASE("VerticesOfPatchesHaveNoSample") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, cut_torus(6000));
  job.reconstruct.method = ReconstructionMethod::kCocone;
  job.fill.keep_outer_border = false;
  job.output.vertex_undersampled = true;
  const RunReport report = run(job);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  std::uint64_t added = 0;
  for (const HoleFacts& hole : report.holes) added += hole.points_added;
  REQUIRE(added > 0);
  std::uint64_t without_sample = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    without_sample += flag_of(mesh.vertices, i) == std::uint8_t{255} ? 1 : 0;
  CHECK(without_sample == added);
}

TEST_CASE("TheColumnLeavesTheMeshAsItIs") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(3000, 0.1, 2));
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  const RunReport before = run(job);
  const TriangleMesh without = read_mesh(job.output.mesh);
  CHECK_FALSE(flag_of(without.vertices, 0));
  job.output.vertex_undersampled = true;
  const RunReport after = run(job);
  const TriangleMesh with = read_mesh(job.output.mesh);
  CHECK(with.vertices.positions == without.vertices.positions);
  CHECK(with.triangles == without.triangles);
  CHECK(after.mesh.checksum == before.mesh.checksum);
  CHECK(with.vertices.schema.attributes.size() == without.vertices.schema.attributes.size() + 1);
}

TEST_CASE("AScansOwnColumnOfThatNameGetsAnother") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  NamedCloud named = painted_torus(1500, 0.1, 2);
  named.cloud.schema.attributes = {{"undersampled", ScalarType::kUint8}};
  named.cloud.attributes.assign(named.cloud.size(), std::byte{7});
  Job job = job_for(scratch, named);
  job.reconstruct.method = ReconstructionMethod::kTightCocone;
  job.output.vertex_undersampled = true;
  run(job);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  REQUIRE(mesh.vertices.schema.attributes.size() == 2);
  CHECK(mesh.vertices.schema.attributes[0].name == "scan_undersampled");
  CHECK(mesh.vertices.schema.attributes[1].name == "undersampled");
  CHECK(mesh.vertices.attribute_row(0)[0] == std::byte{7});
}

TEST_CASE("ThePictureShowsWhereTheScanIsUndersampled") {
  if (!has_voronoi_family()) return;
  ScratchDirectory scratch;
  Job job = job_for(scratch, cut_torus(3000));
  job.reconstruct.method = ReconstructionMethod::kCocone;
  job.output.picture = (scratch / "mesh.png").string();
  run(job);
  const std::string plain = bytes_of(job.output.picture);
  job.output.picture_colors = PictureColors::kUndersampled;
  run(job);
  const std::string colored = bytes_of(job.output.picture);
  CHECK(colored.size() > 1000);
  CHECK((colored != plain));
}

TEST_CASE("MethodsThatDoNotFindUndersamplingRefuseToWriteIt") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(500, 0.0, 1));
  for (const bool is_drawn : {false, true}) {
    job.output.vertex_undersampled = !is_drawn;
    job.output.picture_colors = is_drawn ? PictureColors::kUndersampled : PictureColors::kPatches;
    try {
      run(job);
      FAIL("balls do not find where sampling is sparse");
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::kUsage);
      CHECK_THAT(std::string(error.what()),
                 Catch::Matchers::Contains("undersampled") &&
                     Catch::Matchers::Contains("cocone, super_cocone or tight_cocone"));
    }
  }
}

}  // namespace orbweave
