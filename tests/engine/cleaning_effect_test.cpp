// What the chosen clean-up makes of real scans.
#include <catch2/catch.hpp>
#include <map>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/cleaning/outliers.h"
#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "engine/normals/estimate_normals.h"
#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/layer_thickness.h"
#include "io/clouds/open_point_source.h"
#include "io/points/point_source.h"
#include "io/points/scan_pose.h"
#include "partition/count_grid.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

SpacingSampler sampler_of(const std::vector<Vec3>& positions) {
  CountGrid grid;
  grid.add(positions);
  const RootCube root = root_cube(grid.bounds());
  grid.settle(root.side);
  SpacingSampler sampler(root, grid);
  sampler.add(positions);
  return sampler;
}

std::uint32_t size_of(const PointCloud& cloud) { return static_cast<std::uint32_t>(cloud.size()); }

/// The stages as chosen for the cloud, whose normals are oriented.
void clean(PointCloud& cloud, const CleaningChoice& options, double spacing) {
  auto flags = find_outliers(cloud.positions, 0, size_of(cloud),
                             {.sigma = options.outlier_sigma, .max_radius = 16.0 * spacing});
  for (std::uint8_t& flag : flags) flag ^= 1;
  cloud = kept_points(std::move(cloud), flags);
  for (int pass = 0; pass < options.smooth_passes; ++pass) {
    ProjectedPoints result = project_points(cloud.positions, cloud.normals, 0, size_of(cloud),
                                            {options.smooth_radius, true});
    cloud.positions = std::move(result.positions);
    cloud.normals = std::move(result.normals);
  }
  test::put_in_order(cloud);
  const auto kept = thin_points(cloud.positions, cloud.normals, 0, size_of(cloud),
                                {options.thin_to_spacing, 0.0});
  cloud = kept_points(std::move(cloud), kept);
}

struct Surface {
  std::size_t boundary_edges = 0;
  double used = 0.0;  ///< share of the points
};

Surface surface_of(const PointCloud& cloud) {
  const RadiiChoice radii = sampler_of(cloud.positions).choose(0);
  const auto result = ball_pivoting(cloud.positions, cloud.normals, {}, {radii.radii, {}});
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  std::vector<std::uint8_t> used(cloud.size(), 0);
  for (const Triangle& t : result.triangles) {
    for (int k = 0; k < 3; ++k) {
      used[t[k]] = 1;
      ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    }
  }
  Surface surface;
  for (const auto& [edge, triangles] : edges) surface.boundary_edges += triangles == 1 ? 1 : 0;
  for (const std::uint8_t flag : used) surface.used += flag / static_cast<double>(cloud.size());
  return surface;
}

}  // namespace

TEST_CASE("TheTenBunnyScansBecomeOneSurface") {
  const auto conf = test::data_path("stanford/bunny_scans/bun.conf");
  if (test::skipped_without(conf)) return;
  PointCloud cloud;
  cloud.schema.has_normals = true;
  for (const ScanPose& pose : read_stanford_poses(conf)) {
    const auto source = open_point_source(conf.parent_path() / pose.file);
    for (const Vec3& p : read_all(*source).positions) {
      cloud.positions.push_back(pose.motion.point(p));
      cloud.normals.push_back(pose.motion.direction({0, 0, 1}));  // where the scanner was
    }
  }
  test::put_in_order(cloud);
  const SpacingSampler sampler = sampler_of(cloud.positions);
  const double spacing = sampler.choose(1).spacing;
  const auto estimated = estimate_normals(cloud.positions, 0, size_of(cloud),
                                          {.neighbors = 32, .max_radius = 12.0 * spacing});
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 normal = estimated.normals[i];
    cloud.normals[i] = dot(normal, cloud.normals[i]) < 0.0 ? -normal : normal;
  }
  clean(cloud, choose_cleaning(measure_layers(SearchedSites(sampler.sites()))), spacing);
  const Surface surface = surface_of(cloud);
  CHECK(cloud.size() > 130000);
  CHECK(surface.used > 0.998);
  CHECK(surface.boundary_edges < 1180);
}

TEST_CASE("TheCleanedLionLosesMostOfItsBoundary") {
  const auto path = test::data_path("points_normals/lion_takanawa_normals_rgb.ply");
  if (test::skipped_without(path)) return;
  PointCloud cloud = read_all(*open_point_source(path));
  test::put_in_order(cloud);
  for (Vec3& normal : cloud.normals) normal = normalized(normal);
  const SpacingSampler sampler = sampler_of(cloud.positions);
  const CleaningChoice choice = choose_cleaning(measure_layers(SearchedSites(sampler.sites())));
  REQUIRE(choice.smooth_radius > 0.0);
  clean(cloud, choice, sampler.choose(1).spacing);
  const Surface surface = surface_of(cloud);
  CHECK(cloud.size() > 120000);
  CHECK(surface.used > 0.985);
  CHECK(surface.boundary_edges < 15000);
}

}  // namespace orbweave
