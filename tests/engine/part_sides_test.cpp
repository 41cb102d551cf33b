// Which side whole components show: free space, density and shape, and what is said to be a guess.
#include "engine/normals/part_sides.h"

#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/normals/estimate_normals.h"
#include "engine/normals/free_space.h"
#include "engine/normals/orientation.h"
#include "engine/normals/patch_rays.h"
#include "tests/support/clouds.h"

namespace orbweave {
namespace {

/// A rectangle of points at distances of 1, moved by up to 0.3 in its plane.
void add_wall(Vec3 corner, Vec3 along, Vec3 up, Vec3 normal, PointCloud& cloud) {
  test::Random random(cloud.size() + 1);
  const double columns = norm(along), rows = norm(up);
  for (double i = 0.5; i < columns; i += 1.0)
    for (double k = 0.5; k < rows; k += 1.0) {
      const double s = (i + 0.6 * (random.uniform() - 0.5)) / columns;
      const double t = (k + 0.6 * (random.uniform() - 0.5)) / rows;
      cloud.positions.push_back(corner + s * along + t * up);
      cloud.normals.push_back(normal);
    }
}

/// The six sides of a box; normals outward (1) or inward (-1).
void add_box(Vec3 low, Vec3 size, double side, PointCloud& cloud) {
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 u, v, n;
    u[(axis + 1) % 3] = size[(axis + 1) % 3];
    v[(axis + 2) % 3] = size[(axis + 2) % 3];
    n[axis] = side;
    add_wall(low, u, v, -n, cloud);
    Vec3 high = low;
    high[axis] += size[axis];
    add_wall(high, u, v, n, cloud);
  }
}

PointCloud room() {
  PointCloud cloud;
  add_box({}, {150, 120, 80}, -1.0, cloud);
  return cloud;
}

void add_ball(Vec3 center, double radius, double side, PointCloud& cloud) {
  constexpr double kPi = 3.14159265358979323846;
  for (double row = 0.5; row < kPi * radius; row += 1.0) {
    const double polar = row / radius, around = 2.0 * kPi * radius * std::sin(polar);
    for (double k = 0.0; k < around; k += 1.0) {
      const double angle = k / (radius * std::sin(polar)) + row;
      const Vec3 n{std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle),
                   std::cos(polar)};
      cloud.positions.push_back(center + radius * n);
      cloud.normals.push_back(side * n);
    }
  }
}

/// What a scanner at a place keeps of a cloud: the nearer, the denser.
PointCloud seen_from(Vec3 place, double near, const PointCloud& cloud) {
  test::Random random(3);
  PointCloud seen;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 to = place - cloud.positions[i];
    const double density = near * near * dot(cloud.normals[i], to) / std::pow(norm(to), 3);
    if (random.uniform() >= density) continue;
    seen.positions.push_back(cloud.positions[i]);
    seen.normals.push_back(cloud.normals[i]);
  }
  return seen;
}

struct Oriented {
  double right = 0.0;  // share of points whose sign is that of the cloud
  PatchOrientation found;
};

Oriented oriented(PointCloud cloud, double reach = 6.0, double cell = 16.0) {
  test::put_in_order(cloud);
  const auto size = static_cast<std::uint32_t>(cloud.size());
  const auto normals = estimate_normals(cloud.positions, 0, size, {16, reach}).normals;
  std::vector<std::uint64_t> global(size);
  for (std::uint32_t i = 0; i < size; ++i) global[i] = i;
  const OrientationOptions options{cell, 10, reach};
  const OrientedPatches patches =
      orient_patches(cloud.positions, normals, global, 0, size, options);
  Oriented result;
  result.found = orient_patch_graph(patches.sums, patches.votes, {.cell = options.cell});
  const auto turns = whole_turns(patches.patch_of, patches.turn, result.found);
  for (std::uint32_t i = 0; i < size; ++i)
    result.right += dot(turns[i] ? -normals[i] : normals[i], cloud.normals[i]) > 0.0;
  result.right /= size;
  return result;
}

}  // namespace

TEST_CASE("ARoomInWhichABoardHangsIsSeenFromItsInside") {
  PointCloud cloud = room();
  add_box({30, 30, 30}, {80, 60, 4}, 1.0, cloud);
  const Oriented result = oriented(cloud);
  CHECK(result.right > 0.97);
  CHECK(result.found.interiors == 1);
  CHECK(result.found.doubtful_area < 0.05);
}

TEST_CASE("ABallThatHangsInARoomTurnsTheRoomInward") {
  PointCloud cloud = room();
  add_ball({75, 60, 40}, 12.0, 1.0, cloud);
  const Oriented result = oriented(cloud, 6.0, 8.0);
  CHECK(result.right > 0.97);
  CHECK(result.found.components == 2);
  CHECK(result.found.interiors == 1);
}

TEST_CASE("AnEmptyRoomIsKnownByTheDensityOfItsPoints") {
  PointCloud cloud;
  add_box({}, {180, 140, 100}, -1.0, cloud);
  const PointCloud seen = seen_from({70, 60, 45}, 50.0, cloud);
  const Oriented result = oriented(seen, 20.0);
  CHECK(result.right > 0.97);
  CHECK(result.found.interiors == 1);
  // Scanners close in front of all sides of a block make such densities, too.
  CHECK(result.found.doubtful_area > 0.9);
}

TEST_CASE("AnEvenBoxIsOutwardAndSaidToBeAGuess") {
  PointCloud cloud;
  add_box({}, {90, 70, 50}, 1.0, cloud);
  const Oriented result = oriented(cloud);
  CHECK(result.right == 1.0);
  CHECK(result.found.doubtful_area > 0.9);
  REQUIRE_FALSE(result.found.doubtful.empty());
  CHECK(result.found.doubtful.front().doubt == PartDoubt::kBox);
  CHECK(std::abs(result.found.doubtful.front().center.x - 45.0) < 2.0);
}

TEST_CASE("ClosedObjectsAreNoGuess") {
  PointCloud ball;
  add_ball({}, 30.0, 1.0, ball);
  CHECK(oriented(ball).found.doubtful_area == 0.0);
  const test::NamedCloud torus = test::noisy_torus(20000, 0.2, 1);
  PointCloud scaled = torus.cloud;
  for (Vec3& p : scaled.positions) p = (1.5 / torus.ball_radius) * p;
  const Oriented result = oriented(scaled);
  CHECK(result.right == 1.0);
  CHECK(result.found.interiors == 0);
  CHECK(result.found.doubtful_area == 0.0);
  CHECK(result.found.contested_area == 0.0);
}

TEST_CASE("BothSidesOfAHollowBallsWallShowAwayFromTheWall") {
  PointCloud cloud;
  add_ball({}, 40.0, 1.0, cloud);
  add_ball({}, 35.0, -1.0, cloud);
  CHECK(oriented(cloud, 3.0).right == 1.0);
}

TEST_CASE("ABallWithinABallIsAGuessWhereTheWallIsAsWideAsTheHollow") {
  PointCloud cloud;
  add_ball({}, 40.0, 1.0, cloud);
  add_ball({}, 20.0, -1.0, cloud);
  const Oriented result = oriented(cloud);
  CHECK(result.found.doubtful_area > 0.15);
  REQUIRE_FALSE(result.found.doubtful.empty());
  CHECK(result.found.doubtful.front().doubt == PartDoubt::kNested);
}

TEST_CASE("OpenPartsWithoutAnUpSideAreAGuess") {
  SECTION("a facade") {
    PointCloud cloud;
    add_wall({}, {80, 0, 0}, {0, 0, 60}, {0, -1, 0}, cloud);
    const Oriented result = oriented(cloud);
    CHECK(result.found.doubtful_area > 0.9);
    CHECK(result.found.doubtful.front().doubt == PartDoubt::kSheet);
  }
  SECTION("a tunnel") {
    PointCloud cloud;
    for (int k = 0; k < 16; ++k) {
      const double a = 0.4 * k, b = 0.4 * (k + 1);  // about a turn
      const Vec3 from{0, 20 * std::cos(a), 20 * std::sin(a)},
          to{0, 20 * std::cos(b), 20 * std::sin(b)};
      add_wall(from, {120, 0, 0}, to - from, normalized(-(from + to)), cloud);
    }
    const Oriented result = oriented(cloud);
    CHECK(result.found.doubtful_area > 0.9);
  }
  SECTION("a cave that narrows from one end to the other") {
    PointCloud cloud;
    const auto add_ring = [&](double x, double radius, double wider) {
      const int around = static_cast<int>(6.2832 * radius);
      for (int k = 0; k < around; ++k) {
        const double a = 6.2832 * (k + 0.3 * x) / around;
        cloud.positions.push_back({x, radius * std::cos(a), radius * std::sin(a)});
        cloud.normals.push_back(normalized(Vec3{wider, -std::cos(a), -std::sin(a)}));
      }
    };
    for (int x = 0; x < 120; ++x) add_ring(x, 20.0 + 0.2 * x, 0.2);
    const Oriented result = oriented(cloud);
    CHECK(result.found.doubtful_area > 0.9);
    CHECK(result.found.doubtful.front().doubt == PartDoubt::kTube);
  }
  SECTION("the outer side of a bowl") {
    PointCloud ball, cloud;
    add_ball({}, 40.0, 1.0, ball);
    for (std::size_t i = 0; i < ball.size(); ++i)
      if (ball.positions[i].z < 0.0) {
        cloud.positions.push_back(ball.positions[i]);
        cloud.normals.push_back(ball.normals[i]);
      }
    const Oriented result = oriented(cloud);
    CHECK(result.found.doubtful_area > 0.9);
    CHECK(result.found.doubtful.front().doubt == PartDoubt::kBowl);
  }
}

TEST_CASE("ALevelSheetIsNoGuess") {
  PointCloud cloud;
  add_wall({}, {80, 0, 0}, {0, 60, 0}, {0, 0, 1}, cloud);
  const Oriented result = oriented(cloud);
  CHECK(result.right == 1.0);
  CHECK(result.found.doubtful_area == 0.0);
}

TEST_CASE("LargePartsJoinedByContradictingVotesAreAGuess") {
  std::vector<PatchSum> sums(4);
  for (std::uint64_t i = 0; i < 4; ++i) {
    sums[i].patch = i;
    sums[i].points = 100;
    sums[i].area_normal = {0, 0, 100};
    sums[i].area = 100.0;
  }
  const std::vector<PatchVote> sure = {{0, 1, 9, 9}, {2, 3, 8, 8}, {1, 2, 7, 8}};
  CHECK(orient_patch_graph(sums, sure).weak.empty());
  const std::vector<PatchVote> torn = {{0, 1, 9, 9}, {2, 3, 8, 8}, {1, 2, 2, 8}};
  const PatchOrientation found = orient_patch_graph(sums, torn);
  REQUIRE(found.weak.size() == 1);
  CHECK(found.weak.front().size == 200.0);
  CHECK(found.doubtful_area == Approx(0.5));
}

TEST_CASE("RoundObjectsFaceOutwardWhereverTheLatticeCutsThem") {
  test::Random random(8);
  for (const double points : {15'000.0, 40'000.0, 60'000.0, 110'000.0}) {
    for (int place = 0; place < 3; ++place) {
      const double radius = std::sqrt(points / (4.0 * std::numbers::pi));
      const auto shift = [&] { return 40.0 * (random.uniform() - 0.5); };
      const Vec3 center{shift(), shift(), shift()};
      PointCloud cloud;
      while (static_cast<double>(cloud.size()) < points) {
        const auto along = [&] { return 2.0 * random.uniform() - 1.0; };
        const Vec3 to{along(), along(), along()};
        if (norm(to) > 1.0 || norm(to) < 0.1) continue;
        cloud.normals.push_back(normalized(to));
        cloud.positions.push_back(center + radius * cloud.normals.back());
      }
      const Oriented result = oriented(std::move(cloud));
      CAPTURE(points, center.x, center.y, center.z);
      CHECK(result.right > 0.999);
      CHECK(result.found.interiors == 0);
    }
  }
}

TEST_CASE("ThePlaneOfANeighbourOnARoundSurfaceShutsNothingIn") {
  // Two neighbours of a surface that bends down from one to the next, the second turned over.
  std::vector<PatchSum> sums(2);
  for (std::uint64_t i = 0; i < 2; ++i) {
    PatchSum& sum = sums[i];
    const double slope = i == 0 ? 0.0 : 0.6;
    const Vec3 normal = normalized({slope, 0.0, 1.0});
    const Vec3 center{i == 0 ? 0.0 : 4.0, 0.0, i == 0 ? 0.0 : -0.4};
    sum.patch = i;
    sum.points = 16;
    sum.lowest = center - Vec3{2, 2, slope * 2};
    sum.highest = center + Vec3{2, 2, slope * 2};
    sum.flux_origin = {8.0 * static_cast<double>(i), 0, 0};
    sum.area_normal = (i == 0 ? 16.0 : -16.0) * normal;
    sum.area = 16.0;
    sum.flux = dot(sum.area_normal, center - sum.flux_origin);
  }
  const std::vector<std::uint8_t> turn = {0, 1};
  const PatchRays rays(sums, 8.0, turn, {});
  const Vec3 outward = normalized({0.9, 0.0, 0.3});
  REQUIRE(PatchRays(sums, 8.0, {}, {}).first(0, outward).patch == 1);
  CHECK(rays.first(0, outward).patch == PatchRays::kNothing);
}

namespace {

/// A level square of 16 points, in cells of 8.
PatchSum level_patch(std::uint64_t number, Vec3 corner, double side) {
  PatchSum sum;
  sum.patch = number;
  sum.points = 16;
  sum.lowest = corner;
  sum.highest = corner + Vec3{side, side, 0};
  sum.flux_origin = 8.0 * Vec3{std::floor(corner.x / 8.0), std::floor(corner.y / 8.0),
                               std::floor(corner.z / 8.0)};
  sum.area = side * side;
  sum.area_normal = {0, 0, sum.area};
  sum.flux = sum.area * (corner.z - sum.flux_origin.z);
  return sum;
}

}  // namespace

TEST_CASE("RaysMeetTheNearestPatchThatIsNoLayerOfTheirOwn") {
  // Level patches of 4 x 4 at heights 0, 0.1, 6 and 14; 16 points each lie 1 apart.
  std::vector<PatchSum> sums;
  for (const double height : {0.0, 0.1, 6.0, 14.0})
    sums.push_back(level_patch(sums.size(), {0, 0, height}, 4.0));
  const PatchRays rays(sums, 8.0, {}, {});
  const PatchRays::Hit up = rays.first(0, {0, 0, 1});
  CHECK(up.patch == 2);
  CHECK(up.distance == Approx(6.0));
  CHECK(rays.first(2, {0, 0, 1}).patch == 3);
  CHECK(rays.first(3, {0, 0, -1}).patch == 2);
  CHECK(rays.first(3, {0, 0, 1}).patch == PatchRays::kNothing);
  CHECK(rays.first(0, {1, 0, 0}).patch == PatchRays::kNothing);
}

TEST_CASE("RaysPassEmptySpaceOfAnyWidthAtOnce") {
  // Two level patches far above each other, and one beside the lower one.
  const double far = GENERATE(40.0, 1e5, 1e12);
  std::vector<PatchSum> sums;
  for (const Vec3 corner : {Vec3{0, 0, 0}, Vec3{0, 0, far}, Vec3{-far, 0, 0}})
    sums.push_back(level_patch(sums.size(), corner, 4.0));
  const PatchRays rays(sums, 8.0, {}, {});
  CHECK(rays.first(0, {0, 0, 1}).patch == 1);
  CHECK(rays.first(0, {0, 0, 1}).distance == Approx(far));
  CHECK(rays.first(1, {0, 0, -1}).patch == 0);
  CHECK(rays.first(1, normalized({-1, -1, -1})).patch == PatchRays::kNothing);
  CHECK(rays.first(0, normalized({-1, 1, 1})).patch == PatchRays::kNothing);
  CHECK(rays.first(2, normalized({1, 0, 1})).patch == 1);
}

TEST_CASE("RaysPassThroughTheSameCellsWhereverEmptyOnesLie") {
  // Small level patches at random places: with others far away, rays meet the same.
  test::Random random(3);
  std::vector<PatchSum> sums;
  for (int i = 0; i < 300; ++i) {
    const auto place = [&] { return 100.0 * random.uniform(); };
    sums.push_back(level_patch(sums.size(), {place(), place(), place()}, 6.0));
  }
  const PatchRays rays(sums, 8.0, {}, {});
  std::vector<PatchSum> more = sums;
  for (const double far : {-1e6, 1e9}) {
    more.push_back(sums.front());
    more.back().flux_origin = {8.0 * far, 8.0 * far, 8.0 * far};
    more.back().lowest = more.back().highest = more.back().flux_origin;
    more.back().flux = 0.0;
  }
  const PatchRays among_far(more, 8.0, {}, {});
  int met = 0;
  for (std::uint32_t from = 0; from < sums.size(); ++from) {
    const auto along = [&] { return random.uniform() - 0.5; };
    const Vec3 direction = normalized({along(), along(), along()});
    const PatchRays::Hit hit = rays.first(from, direction);
    met += hit.patch != PatchRays::kNothing ? 1 : 0;
    CHECK(among_far.first(from, direction).patch == hit.patch);
  }
  CHECK(met > 50);
}

TEST_CASE("PatchesWhoseNormalsCancelOutSendNoRays") {
  // All around a point: the sum of the normals is zero, or what rounding leaves of it.
  const Vec3 left = GENERATE(Vec3{}, Vec3{1e-17, -2e-17, 0});
  std::vector<PatchSum> sums(2);
  for (std::uint64_t i = 0; i < 2; ++i) {
    PatchSum& sum = sums[i];
    sum.patch = i;
    sum.points = 8;
    sum.highest = {1, 1, 1};
    sum.area_normal = left;
    sum.area = 8.0;
    sum.flux = 6.0;
  }
  const PatchRays rays(sums, 16.0, {}, {});
  CHECK(rays.normal(0) == Vec3{});
  const std::vector<std::uint32_t> part = {0, 1};
  const std::vector<std::uint8_t> turn = {0, 0};
  const SpaceOfParts found = find_free_space(sums, 16.0, part, turn, {{0, {0}}, {1, {1}}}, nullptr);
  CHECK(found.of_part[0].shut == 0.0);
  CHECK(found.facing.empty());
}

}  // namespace orbweave
