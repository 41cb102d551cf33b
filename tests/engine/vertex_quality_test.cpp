// What vertices tell of the points that they were made from, on request.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "io/meshes/mesh_reader.h"
#include "io/vertex_quality.h"
#include "tests/support/clouds.h"
#include "tests/support/jobs.h"

using namespace orbweave;
using namespace orbweave::test;

namespace {

VertexQuality quality_of(const PointCloud& vertices, std::size_t i) {
  const auto offset = quality_offset(vertices.schema);
  REQUIRE(offset);
  return quality_at(vertices.attribute_row(i).data() + *offset);
}

}  // namespace

TEST_CASE("VerticesCarryTheirQualityOnRequest", "[costly]") {
  ScratchDirectory scratch;
  const NamedCloud named = painted_torus(5000, 0.3, 2);
  Job job = job_for(scratch, named);
  run(job);
  CHECK_FALSE(quality_offset(read_mesh(job.output.mesh).vertices.schema));
  job.output.vertex_quality = true;
  job.cleaning.smooth_radius = 2.5 * named.ball_radius;
  run(job);
  const TriangleMesh mesh = read_mesh(job.output.mesh);
  double spacing = 0.0, moved = 0.0, noise = 0.0;
  std::size_t scanned = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const VertexQuality quality = quality_of(mesh.vertices, i);
    if (quality.normal == NormalOrigin::kInvented) {
      CHECK(quality.spacing == -1.0F);
      CHECK(quality.noise == -1.0F);
      CHECK(quality.moved == -1.0F);
      continue;
    }
    CHECK(quality.normal == NormalOrigin::kGiven);
    spacing += quality.spacing;
    moved += quality.moved;
    noise += quality.noise;
    ++scanned;
  }
  REQUIRE(scanned > 4000);
  const double count = static_cast<double>(scanned);
  const double expected = named.ball_radius / 1.3;
  CHECK(spacing / count > 0.6 * expected);
  CHECK(spacing / count < 1.6 * expected);
  CHECK(noise / count > 0.05 * expected);
  CHECK(noise / count < 0.5 * expected);
  CHECK(moved / count > 0.02 * expected);
  CHECK(moved / count < expected);
}

TEST_CASE("TheQualityLeavesTheMeshAsItIs") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(3000, 0.1, 2));
  run(job);
  const TriangleMesh before = read_mesh(job.output.mesh);
  job.output.vertex_quality = true;
  run(job);
  const TriangleMesh after = read_mesh(job.output.mesh);
  CHECK(after.vertices.positions == before.vertices.positions);
  CHECK(after.vertices.normals == before.vertices.normals);
  CHECK(after.triangles == before.triangles);
  for (std::size_t i = 0; i < after.vertices.size(); ++i) {
    const VertexQuality quality = quality_of(after.vertices, i);
    if (quality.normal != NormalOrigin::kInvented) CHECK(quality.moved == 0.0F);
  }
}

TEST_CASE("TheQualityIsTheSameBytesForAnyPartition", "[costly]") {
  ScratchDirectory scratch;
  Job job = job_for(scratch, painted_torus(4000, 0.4, 5));
  job.output.vertex_quality = true;
  job.cleaning.automatic = true;
  const std::string expected = mesh_bytes(job);
  for (const std::uint64_t chunk_points : {400u, 1'000'000'000u}) {
    job.partition.chunk_points = chunk_points;
    INFO("chunk_points " << chunk_points);
    REQUIRE((mesh_bytes(job) == expected));
  }
}

TEST_CASE("TheQualitySaysWhatDecidedTheSideOfNormals") {
  ScratchDirectory scratch;
  NamedCloud named = painted_torus(3000, 0.0, 2);
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  Job job = job_for(scratch, named);
  job.output.vertex_quality = true;
  for (const auto& [rule, origin] : {std::pair{Orientation::kUp, NormalOrigin::kUp},
                                     std::pair{Orientation::kPropagate, NormalOrigin::kPropagated},
                                     std::pair{Orientation::kNone, NormalOrigin::kNoSide}}) {
    job.normals.orientation = rule;
    run(job);
    const PointCloud vertices = read_mesh(job.output.mesh).vertices;
    REQUIRE(vertices.size() > 100);
    CHECK(quality_of(vertices, 7).normal == origin);
  }
}

TEST_CASE("AQualityOfAnEarlierMeshIsReplaced") {
  ScratchDirectory scratch;
  NamedCloud named = painted_torus(3000, 0.0, 2);
  Job job = job_for(scratch, named);
  job.output.vertex_quality = true;
  run(job);
  const PointSchema once = read_mesh(job.output.mesh).vertices.schema;
  Job again = job;
  again.input.files = {(scratch / "again.ply").string()};
  std::filesystem::copy_file(job.output.mesh, again.input.files.front());
  again.output.mesh = (scratch / "again-mesh.ply").string();
  again.run.work_dir = (scratch / "again.work").string();
  run(again);
  const PointSchema twice = read_mesh(again.output.mesh).vertices.schema;
  CHECK(twice.attributes.size() == once.attributes.size());
  CHECK(quality_offset(twice));
}

TEST_CASE("InventedVerticesAreMarkedInPlaceOfInterpolatedQuality") {
  PointSchema schema;
  schema.attributes = {{"red", ScalarType::kUint8}};
  std::vector<double> values = {200.0};
  mark_invented(schema, values);
  CHECK(values == std::vector<double>{200.0});
  schema.attributes.insert(schema.attributes.end(), quality_fields().begin(),
                           quality_fields().end());
  values = {200.0, 0.1, 0.2, 0.3, 4.0, 100.0, 0.1, 0.2, 0.3, 4.0};
  mark_invented(schema, values);
  CHECK(values == std::vector<double>{200.0, -1, -1, -1, 255, 100.0, -1, -1, -1, 255});
}
