// A chunk with its halo computes what the uncut cloud computes; docs/dev/halo.md derives the width.
#include <algorithm>
#include <catch2/catch.hpp>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/ball_pivoting/halo_width.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using test::NamedCloud;

struct Part {
  std::vector<Vec3> positions, normals;
  std::vector<std::uint8_t> owned;
  std::vector<std::uint32_t> global;
};

bool owns(const Box& box, Vec3 p) {
  return p.x >= box.min.x && p.x < box.max.x && p.y >= box.min.y && p.y < box.max.y &&
         p.z >= box.min.z && p.z < box.max.z;
}

Part cut(const NamedCloud& named, const Box& box, double halo) {
  Part part;
  for (std::uint32_t i = 0; i < named.cloud.size(); ++i) {
    const Vec3 p = named.cloud.positions[i];
    if (!box.grown(halo).contains(p)) continue;
    part.positions.push_back(p);
    part.normals.push_back(named.cloud.normals[i]);
    part.owned.push_back(owns(box, p) ? 1 : 0);
    part.global.push_back(i);
  }
  return part;
}

/// Boxes that tile space around the unit torus, moved by `shift`.
std::vector<Box> tiling(double side, Vec3 shift) {
  std::vector<Box> boxes;
  const int n = static_cast<int>(2.0 / side) + 1;
  for (int z = -n; z <= n; ++z) {
    for (int y = -n; y <= n; ++y) {
      for (int x = -n; x <= n; ++x) {
        const Vec3 low = side * Vec3{double(x), double(y), double(z)} + shift;
        boxes.push_back({low, low + Vec3{side, side, side}});
      }
    }
  }
  return boxes;
}

struct Stitched {
  std::vector<Triangle> triangles;
  std::vector<BoundaryFan> boundary;
  bool fans_agree = true;
  friend bool operator==(const Stitched& a, const Stitched& b) {
    return a.triangles == b.triangles && a.boundary == b.boundary;
  }
};

Stitched in_parts(const NamedCloud& named, const std::vector<double>& radii,
                  const std::vector<Box>& boxes, double halo, const BallPivotingResult& whole) {
  Stitched all;
  for (const Box& box : boxes) {
    const Part part = cut(named, box, halo);
    if (std::find(part.owned.begin(), part.owned.end(), 1) == part.owned.end()) continue;
    const auto result = ball_pivoting(part.positions, part.normals, part.owned, {radii, {}});
    for (const Triangle& t : result.triangles) {
      all.triangles.push_back({part.global[t[0]], part.global[t[1]], part.global[t[2]]});
      for (const std::uint32_t v : t) {
        all.fans_agree = all.fans_agree && result.fans[v] == whole.fans[part.global[v]];
      }
    }
    for (const BoundaryFan& fan : result.boundary) {
      if (part.owned[fan.vertex] == 0) continue;
      all.boundary.push_back(
          {part.global[fan.previous], part.global[fan.vertex], part.global[fan.next]});
    }
  }
  std::sort(all.triangles.begin(), all.triangles.end());
  std::sort(all.boundary.begin(), all.boundary.end());
  return all;
}

Stitched as_stitched(const BallPivotingResult& whole) {
  Stitched all{whole.triangles, whole.boundary, true};
  std::sort(all.boundary.begin(), all.boundary.end());
  return all;
}

std::vector<double> radii_of(const NamedCloud& named, std::vector<double> factors) {
  for (double& factor : factors) factor *= named.ball_radius;
  return factors;
}

}  // namespace

TEST_CASE("EdgesAreALittleLongerThanABallAtMost") {
  // A lattice turned by 45 degrees: its diagonals are 1 long.
  std::vector<Vec3> positions, normals;
  for (int i = -40; i <= 40; ++i) {
    for (int j = -40; j <= 40; ++j) {
      if ((i + j) % 2 != 0) continue;
      positions.push_back({0.5 * i, 0.5 * j, 0.0});
      normals.push_back({0.0, 0.0, 1.0});
    }
  }
  // Balls that are too small for the diagonals but for what points are moved by.
  const std::vector<double> radii = {0.49999995};
  const auto result = ball_pivoting(positions, normals, {}, {radii, {}});
  double longest = 0.0;
  for (const Triangle& t : result.triangles)
    for (int k = 0; k < 3; ++k)
      longest = std::max(longest, norm(positions[t[k]] - positions[t[(k + 1) % 3]]));
  CHECK(longest > 2.0 * radii.back());
  CHECK(longest <= longest_edge(radii));
}

TEST_CASE("WalksReachAsFarAsTheHaloShows") {
  for (const std::vector<double>& radii :
       {std::vector<double>{1.0}, {1.0, 1.5, 2.25, 3.4}, {1.0, 5.0}}) {
    const std::vector<double> reaches = walk_reaches(radii);
    REQUIRE(reaches.size() == radii.size());
    for (std::size_t level = 0; level < radii.size(); ++level) {
      // A walk sees the points within two radii.
      CHECK(reaches[level] + 2.0 * radii[level] <= halo_width(radii) * (1.0 + 1e-12));
      if (level > 0) CHECK(reaches[level] < reaches[level - 1]);
    }
  }
}

TEST_CASE("ChunkedMeshEqualsWholeMesh", "[slow]") {
  const std::vector<std::vector<double>> levels = {
      {1.0}, {1.0, 1.5}, {1.0, 1.5, 2.25, 3.4}, {1.0, 5.0}};
  for (const double noise : {0.0, 0.3, 0.7}) {
    const NamedCloud named = test::noisy_torus(4000, noise, 41);
    for (const auto& factors : levels) {
      if (factors.back() > 3.0 && noise != 0.3) continue;  // their halos reach most of the cloud
      const std::vector<double> radii = radii_of(named, factors);
      const auto whole = ball_pivoting(named.cloud.positions, named.cloud.normals, {}, {radii, {}});
      for (const Vec3 shift : {Vec3{0, 0, 0}, Vec3{0.11, 0.23, 0.05}}) {
        const Stitched parts = in_parts(named, radii, tiling(0.8, shift), halo_width(radii), whole);
        INFO("noise " << noise << ", " << factors.size() << " levels, shift " << shift.x);
        REQUIRE(parts == as_stitched(whole));
        REQUIRE(parts.fans_agree);
      }
    }
  }
}

TEST_CASE("ChunkedMeshEqualsWholeMeshInASpotOfManyPoints", "[slow]") {
  for (const bool on_sphere : {false, true}) {
    const NamedCloud named =
        test::sphere_with_crowd(500, 4500, on_sphere ? 0.02 : 1e-3, on_sphere, 8);
    const std::vector<double> radii = radii_of(named, {1.0, 1.5});
    const auto whole = ball_pivoting(named.cloud.positions, named.cloud.normals, {}, {radii, {}});
    // The spot lies about a corner of eight boxes.
    const Stitched parts = in_parts(named, radii, tiling(2.0, {1, 0, 0}), halo_width(radii), whole);
    INFO(named.name);
    REQUIRE(parts == as_stitched(whole));
    REQUIRE(parts.fans_agree);
  }
}

TEST_CASE("LessHaloIsTooLittle") {
  // The width is a bound for the worst chain of influences; a tenth of it is less than even the
  // walks at owned points see.
  const NamedCloud named = test::noisy_torus(4000, 0.7, 43);
  const std::vector<double> radii = radii_of(named, {1.0});
  const auto whole = ball_pivoting(named.cloud.positions, named.cloud.normals, {}, {radii, {}});
  const Stitched parts =
      in_parts(named, radii, tiling(0.5, {0, 0, 0}), halo_width(radii) / 10.0, whole);
  REQUIRE_FALSE(parts == as_stitched(whole));
}

TEST_CASE("HaloGrowsWithEveryRadius") {
  const std::vector<double> one = {1.0}, two = {1.0, 1.5}, wide = {1.0, 10.0};
  REQUIRE(halo_width(one) == Approx(10.0).epsilon(1e-4));
  REQUIRE(halo_width(two) == Approx(6.0 + 4.0 * 1.5 + 4.0 * 1.5).epsilon(1e-4));
  REQUIRE(halo_width(wide) == Approx(6.0 * 10.0 + 4.0 * 10.0).epsilon(1e-4));
}

}  // namespace orbweave
