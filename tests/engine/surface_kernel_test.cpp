// Loops over neighbourhoods give the same bits at every vector width.
#include "engine/geometry/surface_kernel.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <vector>

#include "engine/geometry/local_surface.h"
#include "engine/geometry/symmetric_eigen.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

constexpr double kReach = 1.0;

template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Points in a cube around a place, some of them on a lattice, with normals near the z axis.
struct Cloud {
  NearPoints points;
  std::vector<Vec3> positions;

  Cloud(test::Random& random, std::uint32_t count) {
    points.reserve(count);
    LaneColumns& p = points.columns.points;
    points.columns.count = count;
    for (std::uint32_t i = 0; i < count; ++i) {
      Vec3 position{4.0 * random.uniform() - 2.0, 4.0 * random.uniform() - 2.0,
                    0.4 * random.uniform()};
      if (i % 3 == 0) position.x = std::floor(position.x);
      Vec3 normal = 0.6 * random.direction();
      normal.z += i % 5 == 0 ? -1.0 : 1.0;
      normal = normalized(normal);
      p.x[i] = position.x;
      p.y[i] = position.y;
      p.z[i] = position.z;
      p.normal_x[i] = normal.x;
      p.normal_y[i] = normal.y;
      p.normal_z[i] = normal.z;
      positions.push_back(position);
    }
    for (std::uint32_t i = count; i % 4 != 0; ++i) p.x[i] = INFINITY;
  }
};

/// Everything that a kernel computes of a place.
struct Results {
  NearPoints near;
  AgreementSums agreement[2];
  std::uint32_t weighed[2];
  SpreadSums spread;
  double condition = 0.0;
  double c[6] = {};

  Results(const SurfaceKernel& kernel, const Cloud& cloud, const double place[3]) {
    const double up[3] = {0.1, -0.2, 0.95};
    const double u[3] = {1, 0, 0}, v[3] = {0, 1, 0}, normal[3] = {0, 0, 1};
    near.reserve(cloud.positions.size());
    kernel.find_near(cloud.points.columns.points, cloud.points.columns.count, place, 0.75, kReach,
                     near.columns);
    for (const bool oriented : {false, true}) {
      kernel.agreement(near.columns, up, oriented, 0.7, agreement[oriented]);
      weighed[oriented] = kernel.weigh(near.columns, up, oriented);
    }
    kernel.spread(near.columns, spread);
    condition = kernel.fit_quadric(near.columns, u, v, normal, c);
  }
};

bool same_rows(const double* a, const double* b, std::uint32_t count) {
  return std::memcmp(a, b, count * sizeof *a) == 0;
}

}  // namespace

TEST_CASE("EveryFormOfTheSurfaceKernelGivesTheSameBits") {
  test::Random random(23);
  for (std::uint32_t count = 0; count < 300; ++count) {
    const Cloud cloud(random, count);
    const double place[3] = {0.25, -0.125, 0.2};
    const Results expected(surface_kernel_generic(), cloud, place);
    const Results found(surface_kernel(), cloud, place);
    const NearColumns &a = expected.near.columns, &b = found.near.columns;
    REQUIRE(a.count == b.count);
    REQUIRE(same_rows(a.points.x, b.points.x, a.count));
    REQUIRE(same_rows(a.points.z, b.points.z, a.count));
    REQUIRE(same_rows(a.points.normal_y, b.points.normal_y, a.count));
    REQUIRE(same_rows(a.squared, b.squared, a.count));
    REQUIRE(same_rows(a.weight, b.weight, a.count));
    for (const bool oriented : {false, true}) {
      REQUIRE(same_bits(expected.agreement[oriented], found.agreement[oriented]));
      REQUIRE(expected.weighed[oriented] == found.weighed[oriented]);
    }
    REQUIRE(same_bits(expected.spread, found.spread));
    REQUIRE(expected.condition == found.condition);
    if (expected.condition > 0.0) REQUIRE(same_bits(expected.c, found.c));
  }
}

TEST_CASE("PointsNearAPlaceAreThoseWithinTheReachInTheirOrder") {
  test::Random random(29);
  const Cloud cloud(random, 201);
  const Vec3 place{0.25, -0.125, 0.2};
  const Results found(surface_kernel(), cloud, &place.x);
  std::uint32_t row = 0;
  for (const Vec3& position : cloud.positions) {
    const Vec3 offset = 0.75 * (position - place);
    if (squared_norm(offset) > kReach) continue;
    REQUIRE(row < found.near.columns.count);
    CHECK(found.near.columns.points.x[row] == offset.x);
    CHECK(found.near.columns.points.y[row] == offset.y);
    CHECK(found.near.columns.squared[row++] == squared_norm(offset));
  }
  CHECK(row == found.near.columns.count);
  CHECK(row > 20);
}

TEST_CASE("FourMatricesHaveTheEigenvectorsOfEachAlone") {
  test::Random random(31);
  for (int trial = 0; trial < 500; ++trial) {
    std::array<SymmetricMatrix, 4> matrices;
    for (int i = 0; i < 4; ++i) {
      const double scale = std::ldexp(1.0, static_cast<int>(random.below(80)) - 40);
      // Of rank zero to three, with equal eigenvalues among them.
      for (std::uint64_t part = random.below(5); part > 0; --part)
        matrices[i] += outer(scale * (part % 2 == 0 ? Vec3{1, 0, 0} : random.direction()));
    }
    for (const SurfaceKernel& kernel : {surface_kernel_generic(), surface_kernel()}) {
      const auto four = eigen_of_four(matrices, kernel);
      for (int i = 0; i < 4; ++i) {
        const SymmetricEigen one = eigen_of(matrices[i]);
        REQUIRE(one.values == four[i].values);
        REQUIRE(one.vectors == four[i].vectors);
      }
    }
  }
}

TEST_CASE("AParaboloidIsFittedExactly") {
  test::Random random(37);
  std::vector<SurfaceSample> samples;
  for (int i = 0; i < 50; ++i) {
    const double x = 2.0 * random.uniform() - 1.0, y = 2.0 * random.uniform() - 1.0;
    samples.push_back(
        {{x, y, 0.125 + 0.1 * x * x - 0.2 * x * y + 0.15 * y * y}, 0.5 + random.uniform()});
  }
  const auto surface = fit_surface(samples, {0, 0, 1});
  REQUIRE(surface);
  REQUIRE(surface->is_quadratic);
  CHECK(surface->normal.z > 0.9);
  for (const SurfaceSample& sample : samples)
    CHECK(std::abs(surface->distance_above(sample.offset)) < 0.05);
  // In the frame of the z axis the heights are a quadric and nothing else.
  NearPoints points;
  points.reserve(samples.size());
  NearColumns& near = points.columns;
  near.count = 48;
  for (std::uint32_t i = 0; i < near.count; ++i) {
    near.points.x[i] = samples[i].offset.x;
    near.points.y[i] = samples[i].offset.y;
    near.points.z[i] = samples[i].offset.z;
    near.weight[i] = samples[i].weight;
  }
  const double u[3] = {1, 0, 0}, v[3] = {0, 1, 0}, normal[3] = {0, 0, 1};
  const double expected[6] = {0.125, 0.0, 0.0, 0.1, -0.2, 0.15};
  double c[6];
  CHECK(surface_kernel().fit_quadric(near, u, v, normal, c) > 1e-4);
  for (int i = 0; i < 6; ++i) CHECK(std::abs(c[i] - expected[i]) < 1e-13);
}

TEST_CASE("SamplesInOneRowOrTwoAreBentByNoQuadric") {
  std::vector<SurfaceSample> row, rows;
  for (int i = 0; i < 20; ++i) {
    const double x = 0.1 * i - 1.0;
    row.push_back({{x, 0.5 * x, 0.25 * x}, 1.0});
    rows.push_back({{x, i % 2 == 0 ? 0.25 : -0.25, 0.0}, 1.0});
  }
  CHECK_FALSE(fit_surface(row, {0, 0, 1}));
  const auto plane = fit_surface(rows, {0, 0, 1});
  REQUIRE(plane);
  CHECK_FALSE(plane->is_quadratic);
}

}  // namespace orbweave
