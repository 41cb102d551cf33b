// Reconstructs twelve points through the installed libraries: one call into each of the folders.
#include <cmath>
#include <cstdio>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "io/error.h"
#include "io/point_cloud.h"
#include "partition/canonical_order.h"

namespace {

orbweave::PointCloud icosahedron() {
  orbweave::PointCloud cloud;
  cloud.schema.has_normals = true;
  const double golden = (1.0 + std::sqrt(5.0)) / 2.0;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-golden, golden}) {
      for (const orbweave::Vec3 p : {orbweave::Vec3{0, a, b}, {a, b, 0}, {b, 0, a}}) {
        cloud.positions.push_back(p);
        cloud.normals.push_back(p);
      }
    }
  }
  return cloud;
}

}  // namespace

int main() {
  try {
    orbweave::PointCloud cloud = icosahedron();
    orbweave::sort_canonically(cloud, orbweave::root_cube(cloud.bounds()));
    orbweave::BallPivotingOptions options;
    options.ball_radii = {1.5};  // edges are 2 long, circumradii 1.155
    const auto result = orbweave::ball_pivoting(cloud.positions, cloud.normals, {}, options);
    std::printf("%zu triangles, 20 expected\n", result.triangles.size());
    return result.triangles.size() == 20 ? 0 : 1;
  } catch (const orbweave::Error& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
