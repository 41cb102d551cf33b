#include "engine/normals/estimate_normals.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <tuple>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/geometry/neighbor_search.h"
#include "engine/geometry/symmetric_eigen.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

EstimatedNormals all_normals(const PointCloud& cloud, const NormalEstimateOptions& options) {
  return estimate_normals(cloud.positions, 0, static_cast<std::uint32_t>(cloud.size()), options);
}

bool same_bits(const Vec3& a, const Vec3& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

PointCloud moved(PointCloud cloud, double scale, Vec3 offset) {
  for (Vec3& p : cloud.positions) p = scale * p + offset;
  return cloud;
}

PointCloud cloud_of(std::vector<Vec3> positions) {
  PointCloud cloud;
  cloud.positions = std::move(positions);
  test::put_in_order(cloud);
  return cloud;
}

double largest_angle_sine(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, norm(cross(a[i], b[i])));
  return worst;
}

}  // namespace

TEST_CASE("NeighborSearchFindsTheSameAsComparingWithAll") {
  // Grids are full of equal distances; the ball is nothing like a surface.
  for (const PointCloud& cloud :
       {test::grid_sheet(24, 0.5).cloud, test::random_ball(900, 3).cloud}) {
    const NeighborSearch search(cloud.positions);
    NeighborSearch::Query query;
    const double max_squared = search.size() > 900 ? 9.0 : std::numeric_limits<double>::max();
    for (std::uint32_t i = 0; i < search.size(); i += 7) {
      const std::uint32_t block = i / NeighborSearch::kBlock * NeighborSearch::kBlock;
      query.find(search, block, std::min(block + NeighborSearch::kBlock, search.size()), 20,
                 max_squared);
      std::vector<Neighbor> all;
      for (std::uint32_t j = 0; j < search.size(); ++j) {
        const double squared = squared_norm(cloud.positions[j] - cloud.positions[i]);
        if (j != i && squared <= max_squared) all.push_back({squared, j});
      }
      std::sort(all.begin(), all.end(), [](const Neighbor& a, const Neighbor& b) {
        return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance
                                                        : a.index < b.index;
      });
      all.resize(std::min<std::size_t>(all.size(), 20));
      std::sort(all.begin(), all.end(),
                [](const Neighbor& a, const Neighbor& b) { return a.index < b.index; });
      const auto found = query.of(i);
      const auto squared = query.squared_of(i);
      REQUIRE(found.size() == all.size());
      for (std::size_t k = 0; k < all.size(); ++k)
        REQUIRE(all[k] == Neighbor{squared[k], found[k]});
    }
  }
}

TEST_CASE("EigenvectorsAreThoseOfTheMatrixAtEveryScale") {
  test::Random random(5);
  for (const double scale : {1e-250, 1e-12, 1.0, 1e12, 1e250}) {
    for (int trial = 0; trial < 50; ++trial) {
      SymmetricMatrix m;
      for (int i = 0; i < 4; ++i) m += outer(random.direction());
      for (double* entry : {&m.xx, &m.xy, &m.xz, &m.yy, &m.yz, &m.zz}) *entry *= scale;
      const SymmetricEigen e = eigen_of(m);
      CHECK(e.values[0] <= e.values[1]);
      CHECK(e.values[1] <= e.values[2]);
      for (int i = 0; i < 3; ++i) {
        const Vec3 v = e.vectors[i];
        const Vec3 image{m.xx * v.x + m.xy * v.y + m.xz * v.z, m.xy * v.x + m.yy * v.y + m.yz * v.z,
                         m.xz * v.x + m.yz * v.y + m.zz * v.z};
        CHECK(norm((image - e.values[i] * v) / scale) < 1e-14);
        CHECK(std::abs(norm(v) - 1.0) < 1e-15);
      }
    }
  }
  CHECK(eigen_of({}).values[2] == 0.0);
}

TEST_CASE("EstimatedNormalsAreThoseOfTheSurface") {
  const test::NamedCloud torus = test::noisy_torus(20000, 0.0, 1);
  const EstimatedNormals found = all_normals(torus.cloud, {16, 4.0 * torus.ball_radius});
  CHECK(largest_angle_sine(found.normals, torus.cloud.normals) < 0.03);
  for (const Vec3& n : found.normals) REQUIRE(std::abs(norm(n) - 1.0) < 1e-14);
  CHECK(*std::max_element(found.roughness.begin(), found.roughness.end()) < 0.1f);
}

TEST_CASE("NormalsOfAPartAreThoseOfTheWholeToTheLastBit") {
  const test::NamedCloud torus = test::noisy_torus(8000, 0.4, 9);
  const test::NamedCloud grid = test::grid_sheet(60, 0.4);
  for (const test::NamedCloud& named : {torus, grid}) {
    const PointCloud& cloud = named.cloud;
    const NormalEstimateOptions options{16, 2.0 * named.ball_radius};
    const EstimatedNormals whole = all_normals(cloud, options);
    const auto size = static_cast<std::uint32_t>(cloud.size());
    for (std::uint32_t part = 0; part < 11; ++part) {
      const std::uint32_t begin = part * size / 11, end = (part + 1) * size / 11;
      Vec3 low = cloud.positions[begin], high = low;
      for (std::uint32_t i = begin; i < end; ++i)
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], cloud.positions[i][axis]);
          high[axis] = std::max(high[axis], cloud.positions[i][axis]);
        }
      std::vector<Vec3> chunk;
      std::uint32_t owned = 0;
      for (std::uint32_t i = 0; i < size; ++i) {
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis)
          inside = inside && cloud.positions[i][axis] >= low[axis] - options.max_radius &&
                   cloud.positions[i][axis] <= high[axis] + options.max_radius;
        if (i == begin) owned = static_cast<std::uint32_t>(chunk.size());
        if (inside) chunk.push_back(cloud.positions[i]);
      }
      REQUIRE(chunk.size() < cloud.size());
      const EstimatedNormals found = estimate_normals(chunk, owned, owned + (end - begin), options);
      for (std::uint32_t i = begin; i < end; ++i) {
        REQUIRE(same_bits(found.normals[i - begin], whole.normals[i]));
        REQUIRE(found.roughness[i - begin] == whole.roughness[i]);
      }
    }
  }
}

TEST_CASE("ScaleAndOffsetDoNotMatter") {
  test::NamedCloud torus = test::noisy_torus(4000, 0.2, 2);
  // Coordinates that every place below holds exactly.
  for (Vec3& p : torus.cloud.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] * 0x1p20) * 0x1p-20;
  const double radius = 3.0 * torus.ball_radius;
  const EstimatedNormals here = all_normals(torus.cloud, {16, radius});
  const Vec3 utm{691000.0, 5334000.0, 512.0};
  const EstimatedNormals far = all_normals(moved(torus.cloud, 1.0, utm), {16, radius});
  CHECK(far.normals == here.normals);
  for (const double scale : {0x1p-20, 0x1p20}) {
    const EstimatedNormals scaled =
        all_normals(moved(torus.cloud, scale, {}), {16, scale * radius});
    CHECK(scaled.normals == here.normals);
  }
  for (const double scale : {1e-6, 1e6}) {
    const EstimatedNormals scaled =
        all_normals(moved(torus.cloud, scale, {}), {16, scale * radius});
    CHECK(largest_angle_sine(scaled.normals, here.normals) < 1e-6);
  }
}

TEST_CASE("PointsOfACubeShareTheNormalOfOneOfThemWhereItHasOne") {
  PointCloud cloud = test::noisy_torus(4000, 0.2, 2).cloud;
  cloud.positions.push_back({9.0, 9.0, 9.0});  // alone
  cloud.normals.push_back({0.0, 0.0, 1.0});
  test::put_in_order(cloud);
  const NormalEstimateOptions own{.neighbors = 16, .max_radius = 0.3};
  NormalEstimateOptions shared = own;
  shared.shared_side = 0.1;
  const std::vector<Vec3> of_points = all_normals(cloud, own).normals;
  const std::vector<Vec3> of_cubes = all_normals(cloud, shared).normals;
  std::map<std::tuple<double, double, double>, Vec3> cubes;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 p = cloud.positions[i] / shared.shared_side;
    const auto cube = std::tuple(std::floor(p.x), std::floor(p.y), std::floor(p.z));
    CHECK(cubes.emplace(cube, of_cubes[i]).first->second == of_cubes[i]);
    CHECK((of_points[i] == Vec3{}) == (of_cubes[i] == Vec3{}));
  }
  CHECK(cubes.size() * 2 < cloud.size());
  shared.shared_side = 1e-6;
  CHECK(all_normals(cloud, shared).normals == of_points);
}

TEST_CASE("ScanRowsFarApartStillTellThePlane") {
  // Forty points along a row before the next row begins: the 16 nearest lie on one line.
  std::vector<Vec3> positions;
  for (int row = 0; row < 12; ++row)
    for (int i = 0; i < 480; ++i) positions.push_back({0.025 * i, double(row), 0.1 * row});
  const PointCloud cloud = cloud_of(positions);
  const Vec3 plane = normalized(Vec3{0.0, -0.1, 1.0});
  const EstimatedNormals found = all_normals(cloud, {16, 3.0});
  for (const Vec3& n : found.normals) REQUIRE(norm(cross(n, plane)) < 1e-9);
  // Within half the distance of the rows there is nothing but a row.
  for (const Vec3& n : all_normals(cloud, {16, 0.5}).normals) REQUIRE(n == Vec3{});
}

TEST_CASE("FewOrCollinearNeighborsGiveNoNormal") {
  CHECK(estimate_normals({}, 0, 0, {16, 1.0}).normals.empty());
  const PointCloud few = cloud_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, 9, 9}});
  for (const Vec3& n : all_normals(few, {16, 2.0}).normals) CHECK(n == Vec3{});
  const PointCloud four = cloud_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
  for (const Vec3& n : all_normals(four, {16, 2.0}).normals) CHECK(n == Vec3{0, 0, 1});
  std::vector<Vec3> line;
  for (int i = 0; i < 100; ++i) line.push_back({0.1 * i, 0.3 * i + 5e5, 0.7 * i});
  for (const Vec3& n : all_normals(cloud_of(line), {16, 1e6}).normals) CHECK(n == Vec3{});
}

TEST_CASE("TheSignIsThatOfTheLargestComponent") {
  const test::NamedCloud sphere = test::random_sphere(3000, 4);
  for (const Vec3& n : all_normals(sphere.cloud, {16, 1.0}).normals) {
    const double largest = std::max({n.x, n.y, n.z});
    REQUIRE(largest >= -std::min({n.x, n.y, n.z}));
  }
}

}  // namespace orbweave
