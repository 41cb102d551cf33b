// Ten thousand holes in two million points, through the whole pipeline.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "engine/synthetic/synthetic_cloud.h"
#include "tests/support/jobs.h"

namespace orbweave {
namespace {

constexpr std::size_t kHoles = 10'000;

PointCloud whole_torus(const SyntheticOptions& options) {
  SyntheticCloud source(options);
  PointCloud cloud;
  cloud.schema = source.schema();
  PointCloud batch;
  batch.schema = cloud.schema;
  while (source.read(batch, 1 << 16)) {
    cloud.append(batch);
    batch.clear();
  }
  return cloud;
}

/// Drops the points in round holes that are well apart.
void punch(PointCloud& cloud, double radius) {
  // Seen from above and below, a hole in the middle of every cell.
  const double cell = 4.6 * radius;
  const auto hole_of = [&](Vec3 p) {
    const Vec3 middle{(std::floor(p.x / cell) + 0.5) * cell, (std::floor(p.y / cell) + 0.5) * cell,
                      0.0};
    return std::hypot(p.x - middle.x, p.y - middle.y) < radius && std::abs(p.z) > 0.3;
  };
  PointCloud kept;
  kept.schema = cloud.schema;
  kept.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!hole_of(cloud.positions[i])) kept.append(cloud, i);
  }
  cloud = std::move(kept);
}

}  // namespace

TEST_CASE("TenThousandSmallHolesInTwoMillionPointsAreClosed") {
  SyntheticOptions options;
  options.shape = Shape::kTorus;
  options.points = 2'000'000;
  test::NamedCloud named{"torus", whole_torus(options), 1.3 * spacing(options)};
  punch(named.cloud, 1.8 * spacing(options));
  test::ScratchDirectory scratch;
  Job job = test::job_for(scratch, named);
  job.reconstruct.ball_radii = {named.ball_radius};
  job.partition.chunk_points = 200'000;
  job.run.threads = 2;
  job.partition.memory_bytes = std::uint64_t{1} << 30;
  const RunReport report = test::run(job);
  REQUIRE(report.holes.size() >= kHoles);
  CHECK(std::all_of(report.holes.begin(), report.holes.end(),
                    [](const HoleFacts& hole) { return hole.filled; }));
  CHECK(report.mesh.watertight);
  CHECK(report.mesh.euler_characteristic == 0);
  CHECK(report.mesh.components == 1);
  CHECK(report.peak_memory_bytes < job.partition.memory_bytes);
  const auto dihedral = [](const HoleFacts& hole) { return hole.rim_dihedral_deg; };
  CHECK(dihedral(*std::max_element(report.holes.begin(), report.holes.end(),
                                   [&](const HoleFacts& a, const HoleFacts& b) {
                                     return dihedral(a) < dihedral(b);
                                   })) < 20.0);
}

}  // namespace orbweave
