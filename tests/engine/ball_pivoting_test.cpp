// Order-free ball pivoting against an oracle that tries every triple, and against itself under
// everything that must not matter.
#include "engine/ball_pivoting/ball_pivoting.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "engine/ball_pivoting/cell_grid.h"
#include "engine/ball_pivoting/fan_table.h"
#include "engine/ball_pivoting/general_position.h"
#include "engine/ball_pivoting/parts.h"
#include "engine/ball_pivoting/rivals.h"
#include "io/error.h"
#include "io/report/report.h"
#include "tests/support/clouds.h"
#include "tests/support/vector_widths.h"

namespace orbweave {
namespace {

using test::NamedCloud;

std::vector<Vec3> perturbed(const NamedCloud& named) {
  return general_position(named.cloud.positions, {}, lattice_step({{named.ball_radius}}));
}

/// Centre of the ball on the positive side of a, b, c, by linear algebra of its own.
std::optional<Vec3> oracle_center(Vec3 a, Vec3 b, Vec3 c, double ball_radius) {
  const Vec3 ab = b - a, ac = c - a, n = cross(ab, ac);
  const double nn = squared_norm(n);
  if (!(nn > 0.0)) return std::nullopt;
  const Vec3 offset =
      (squared_norm(ac) * cross(n, ab) + squared_norm(ab) * cross(ac, n)) / (2 * nn);
  const double rest = ball_radius * ball_radius - squared_norm(offset);
  if (rest < 0.0) return std::nullopt;
  return a + offset + std::sqrt(rest / nn) * n;
}

bool oracle_accepts(const std::vector<Vec3>& p, const std::vector<Vec3>& normals, const Triangle& t,
                    double ball_radius) {
  const Vec3 n = cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
  for (const std::uint32_t v : t) {
    if (!(dot(n, normals[v]) > 0.0)) return false;
  }
  const auto center = oracle_center(p[t[0]], p[t[1]], p[t[2]], ball_radius);
  if (!center) return false;
  for (std::uint32_t k = 0; k < p.size(); ++k) {
    if (k == t[0] || k == t[1] || k == t[2]) continue;
    if (squared_norm(p[k] - *center) < ball_radius * ball_radius) return false;
  }
  return true;
}

/// All of T_rho, by trying every triple in both orientations.
std::set<Triangle> oracle(const NamedCloud& named) {
  const std::vector<Vec3> p = perturbed(named);
  const auto n = static_cast<std::uint32_t>(p.size());
  const double reach = 4.0 * named.ball_radius * named.ball_radius;
  std::set<Triangle> found;
  for (std::uint32_t a = 0; a < n; ++a) {
    for (std::uint32_t b = a + 1; b < n; ++b) {
      if (squared_norm(p[b] - p[a]) > reach) continue;
      for (std::uint32_t c = b + 1; c < n; ++c) {
        for (const Triangle& t : {Triangle{a, b, c}, Triangle{a, c, b}}) {
          if (oracle_accepts(p, named.cloud.normals, t, named.ball_radius)) found.insert(t);
        }
      }
    }
  }
  return found;
}

FanTable walk(const NamedCloud& named, VectorWidth width) {
  const CellSpace space(named.ball_radius, lattice_step({{named.ball_radius}}), {});
  const CellGrid grid(perturbed(named), named.cloud.normals, space);
  return walk_all(grid, named.ball_radius, {}, width);
}

std::set<Triangle> all_found(const FanTable& fans) {
  std::set<Triangle> found;
  for (std::uint32_t v = 0; v < fans.points(); ++v) {
    for (const Corner c : fans.at(v)) {
      found.insert(smallest_first(Triangle{v, first_of(c), second_of(c)}));
    }
  }
  return found;
}

BallPivotingResult reconstruct(const NamedCloud& named, std::vector<double> factors = {1.0},
                               VectorWidth width = widest_supported()) {
  for (double& factor : factors) factor *= named.ball_radius;
  return ball_pivoting(named.cloud.positions, named.cloud.normals, {}, {factors, width});
}

using Edge = std::pair<std::uint32_t, std::uint32_t>;

std::map<Edge, int> directed_edges(const std::vector<Triangle>& triangles) {
  std::map<Edge, int> edges;
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  return edges;
}

std::size_t boundary_edges(const std::vector<Triangle>& triangles) {
  const auto edges = directed_edges(triangles);
  std::size_t count = 0;
  for (const auto& [edge, uses] : edges) count += edges.count({edge.second, edge.first}) == 0;
  return count;
}

}  // namespace

TEST_CASE("WalksInventNothing") {
  for (const NamedCloud& named : test::clouds_for_oracle()) {
    const std::set<Triangle> expected = oracle(named);
    for (const Triangle& t : all_found(walk(named, widest_supported()))) {
      INFO(named.name << ": " << t[0] << " " << t[1] << " " << t[2]);
      REQUIRE(expected.count(t) == 1);
    }
  }
}

TEST_CASE("WalksFindEveryTriangleThatHasRoom") {
  // A triangle may be missing only where each of its vertices has a closed fan without it: there
  // it could only make all three vertices non-manifold (docs/dev/ball-pivoting.md).
  for (const NamedCloud& named : test::clouds_for_oracle()) {
    const FanTable fans = walk(named, widest_supported());
    const std::set<Triangle> found = all_found(fans);
    const std::set<Triangle> expected = oracle(named);
    REQUIRE(!expected.empty());
    for (const Triangle& t : expected) {
      if (found.count(t) == 1) continue;
      INFO(named.name << ": " << t[0] << " " << t[1] << " " << t[2]);
      REQUIRE((fans.closed(t[0]) && fans.closed(t[1]) && fans.closed(t[2])));
    }
  }
}

void require_all_that_has_room(const NamedCloud& named) {
  const std::set<Triangle> expected = oracle(named);
  REQUIRE(expected.size() > 15);
  for (const VectorWidth width : test::supported_widths()) {
    INFO(named.name << ", width " << static_cast<int>(width));
    const FanTable fans = walk(named, width);
    const std::set<Triangle> found = all_found(fans);
    for (const Triangle& t : found) REQUIRE(expected.count(t) == 1);
    for (const Triangle& t : expected) {
      const bool closed = fans.closed(t[0]) && fans.closed(t[1]) && fans.closed(t[2]);
      REQUIRE((closed || found.count(t) == 1));
    }
  }
}

TEST_CASE("CrowdedWalksFindEveryTriangleThatHasRoomAndInventNone", "[costly]") {
  // Hundreds of points per ball: most circles are settled by the nearest caps alone.
  const double growth = GENERATE(1.6, 2.2, 4.0);
  NamedCloud crowd = test::noisy_torus(420, 0.8, 5);
  crowd.ball_radius *= growth;
  require_all_that_has_room(crowd);
}

TEST_CASE("WalksInSpotsAndPatchesFindEveryTriangleThatHasRoomAndInventNone", "[costly]") {
  // Far more points per ball than bound what is free, of which there is much at most of them.
  for (const double width : {1e-4, 0.3}) {
    for (const bool on_sphere : {false, true}) {
      NamedCloud crowd = test::sphere_with_crowd(50, 300, width, on_sphere, 9);
      crowd.ball_radius = 0.6;
      require_all_that_has_room(crowd);
    }
  }
  NamedCloud ball = test::random_ball(330, 4);
  ball.ball_radius *= 3.0;
  require_all_that_has_room(ball);
}

TEST_CASE("ASpotThatIsFarDenserThanTheBallIsWideIsReconstructed") {
  // Thousands of points with nearly all others in reach of the ball: with each of them looked at
  // against each at each, this would not end.
  const NamedCloud spot = test::sphere_with_crowd(2000, 6000, 1e-4, false, 3);
  CHECK(reconstruct(spot).triangles.size() > 3000);
}

TEST_CASE("ScansOfActivePointsFindEveryTriangleOfTheirs") {
  for (NamedCloud& named : test::clouds_for_oracle()) {
    const CellSpace space(named.ball_radius, lattice_step({{named.ball_radius}}), {});
    const CellGrid grid(perturbed(named), named.cloud.normals, space);
    std::vector<std::uint8_t> active(grid.size(), 1);
    for (std::size_t i = 0; i < active.size(); i += 7) active[i] = 0;
    std::set<Triangle> expected = oracle(named);
    std::erase_if(expected, [&](const Triangle& t) {
      return active[t[0]] == 0 || active[t[1]] == 0 || active[t[2]] == 0;
    });
    for (const VectorWidth width : test::supported_widths()) {
      INFO(named.name << ", width " << static_cast<int>(width));
      const FanTable fans = walk_all(grid, named.ball_radius, active, width);
      CHECK(all_found(fans) == expected);
    }
  }
}

TEST_CASE("ScansLeaveOutNoTriangleWhoseEdgesAreFree") {
  for (NamedCloud& named : test::clouds_for_oracle()) {
    const CellSpace space(named.ball_radius, lattice_step({{named.ball_radius}}), {});
    const CellGrid grid(perturbed(named), named.cloud.normals, space);
    const std::vector<std::uint8_t> active(grid.size(), 1);
    const std::set<Triangle> expected = oracle(named);
    std::vector<VertexCorner> taken;
    std::set<Edge> taken_edges;
    std::size_t number = 0;
    for (const Triangle& t : expected) {
      if (number++ % 5 != 0) continue;
      for (int k = 0; k < 3; ++k) {
        taken.push_back({t[k], make_corner(t[(k + 1) % 3], t[(k + 2) % 3])});
        taken_edges.insert({t[k], t[(k + 1) % 3]});
      }
    }
    std::sort(taken.begin(), taken.end());
    for (const VectorWidth width : test::supported_widths()) {
      INFO(named.name << ", width " << static_cast<int>(width));
      const std::set<Triangle> found =
          all_found(walk_all(grid, named.ball_radius, active, width, nullptr, taken));
      CHECK(std::includes(expected.begin(), expected.end(), found.begin(), found.end()));
      for (const Triangle& t : expected) {
        bool free = true;
        for (int k = 0; k < 3; ++k) free = free && !taken_edges.contains({t[k], t[(k + 1) % 3]});
        if (free) REQUIRE(found.contains(t));
      }
    }
  }
}

TEST_CASE("ABlockedPointHasNoTriangleAtAnyLargerRadius") {
  std::size_t blocked = 0;
  for (const double growth : {1.0, 1.3, 2.0}) {
    NamedCloud named = test::noisy_torus(300, 0.9, 6);
    named.ball_radius *= 1.5;
    const FanTable fans = walk(named, widest_supported());
    named.ball_radius *= growth;
    for (const Triangle& t : oracle(named))
      for (const std::uint32_t v : t) REQUIRE_FALSE(fans.blocked(v));
    for (std::uint32_t v = 0; v < fans.points(); ++v) blocked += fans.blocked(v) ? 1 : 0;
  }
  CHECK(blocked > 30);
}

TEST_CASE("OnCleanSurfacesAllOfTheTargetSetIsFound") {
  for (const NamedCloud& named : {test::noisy_torus(150, 0.0, 1), test::noisy_torus(150, 0.2, 2),
                                  test::grid_sheet(10, 0.0)}) {
    INFO(named.name);
    REQUIRE(all_found(walk(named, widest_supported())) == oracle(named));
  }
}

TEST_CASE("VectorWidthChangesNoDecision") {
  std::vector<NamedCloud> clouds = test::clouds_for_oracle();
  clouds.push_back(test::noisy_torus(5000, 0.4, 7));
  for (const NamedCloud& named : clouds) {
    const BallPivotingResult scalar = reconstruct(named, {1.0, 1.5, 2.25}, VectorWidth::kScalar);
    for (const VectorWidth width : test::supported_widths()) {
      INFO(named.name << ", width " << static_cast<int>(width));
      REQUIRE(reconstruct(named, {1.0, 1.5, 2.25}, width).triangles == scalar.triangles);
    }
  }
}

TEST_CASE("ThreadsChangeNothing") {
  const NamedCloud named = test::noisy_torus(20000, 0.4, 11);
  const BallPivotingResult expected = reconstruct(named, {1.0, 1.5});
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena arena(threads);
    arena.execute([&] {
      const BallPivotingResult result = reconstruct(named, {1.0, 1.5});
      REQUIRE(result.triangles == expected.triangles);
      REQUIRE(result.fans == expected.fans);
      REQUIRE(result.boundary == expected.boundary);
    });
  }
}

TEST_CASE("NoEdgeHasMoreThanTwoTrianglesNorIsUsedTwiceInOneDirection") {
  for (const double noise : {0.0, 0.1, 0.3, 0.6, 1.2}) {
    const NamedCloud named = test::noisy_torus(4000, noise, 3);
    for (const auto& factors : {std::vector<double>{1.0}, std::vector<double>{1.0, 1.6, 2.5}}) {
      const BallPivotingResult result = reconstruct(named, factors);
      REQUIRE(!result.triangles.empty());
      for (const auto& [edge, uses] : directed_edges(result.triangles)) REQUIRE(uses == 1);
    }
  }
}

TEST_CASE("NoTriangleStandsAlone") {
  const NamedCloud named = test::noisy_torus(4000, 0.9, 5);
  const BallPivotingResult result = reconstruct(named);
  const auto edges = directed_edges(result.triangles);
  REQUIRE(result.isolated_dropped > 0);
  for (const Triangle& t : result.triangles) {
    int neighbours = 0;
    for (int k = 0; k < 3; ++k) neighbours += edges.count({t[(k + 1) % 3], t[k]}) != 0 ? 1 : 0;
    REQUIRE(neighbours > 0);
  }
}

namespace {

/// A point with `pairs` triangles that stand alone and `triples` of two triangles each: their other
/// vertices are close together on the unit sphere around the point, which comes first.
NamedCloud star(int pairs, int triples) {
  constexpr double kApart = 0.02, kGoldenAngle = 2.39996322972865332;
  NamedCloud named{"star", {}, 0.501};
  named.cloud.positions = {Vec3{}};
  named.cloud.normals = {Vec3{0.0, 0.0, 1.0}};
  for (int i = 0; i < pairs + triples; ++i) {
    const double z = 0.9 - 1.8 * (i + 0.5) / (pairs + triples);
    const double angle = kGoldenAngle * i, flat = std::sqrt(1.0 - z * z);
    const Vec3 out{flat * std::cos(angle), flat * std::sin(angle), z};
    const Vec3 east{-std::sin(angle), std::cos(angle), 0.0};
    for (int k = 0; k < (i < pairs ? 2 : 3); ++k) {
      named.cloud.positions.push_back(normalized(out + kApart * k * east));
      named.cloud.normals.push_back(cross(out, east));
    }
  }
  return named;
}

}  // namespace

TEST_CASE("FansAreCountedAtAPointOfHundredsOfTrianglesThatStandAlone") {
  const BallPivotingResult result = reconstruct(star(300, 3));
  REQUIRE(result.isolated_dropped > 255);
  std::set<std::uint32_t> firsts, seconds;  // neighbours of the point in its triangles
  for (const Triangle& t : result.triangles) {
    if (t[0] != 0) continue;
    firsts.insert(t[1]);
    seconds.insert(t[2]);
  }
  REQUIRE_FALSE(firsts.empty());
  // A fan begins with a neighbour at which no other triangle of it ends.
  const auto fans = std::ranges::count_if(
      firsts, [&](std::uint32_t neighbor) { return !seconds.contains(neighbor); });
  CHECK(fans > 0);
  CHECK(result.fans[0] == fans);
}

TEST_CASE("CleanTorusIsClosedWithTwiceAsManyTrianglesAsVertices") {
  for (const std::size_t points : {500u, 3000u, 20000u}) {
    const NamedCloud named = test::noisy_torus(points, 0.0, 1);
    const BallPivotingResult result = reconstruct(named);
    REQUIRE(result.triangles.size() == 2 * named.cloud.size());
    REQUIRE(boundary_edges(result.triangles) == 0);
    REQUIRE(result.boundary.empty());
    REQUIRE(std::all_of(result.fans.begin(), result.fans.end(), [](auto f) { return f == 1; }));
  }
}

TEST_CASE("RegularGridIsOneSheetWithoutGaps") {
  const NamedCloud named = test::grid_sheet(40, 0.0);
  const BallPivotingResult result = reconstruct(named);
  REQUIRE(result.triangles.size() == 2 * 39 * 39);
  REQUIRE(boundary_edges(result.triangles) == 4 * 39);
  REQUIRE(result.boundary.size() == 4 * 39);
}

TEST_CASE("BoundaryFansAreTheBoundaryEdges") {
  for (const double noise : {0.3, 0.7}) {
    const NamedCloud named = test::noisy_torus(3000, noise, 17);
    const BallPivotingResult result = reconstruct(named, {1.0, 1.7});
    const auto edges = directed_edges(result.triangles);
    std::set<Edge> arriving, leaving, expected;
    for (const BoundaryFan& fan : result.boundary) {
      arriving.insert({fan.previous, fan.vertex});
      leaving.insert({fan.vertex, fan.next});
    }
    for (const auto& [edge, uses] : edges) {
      if (edges.count({edge.second, edge.first}) == 0) expected.insert(edge);
    }
    REQUIRE(arriving == expected);
    REQUIRE(leaving == expected);
    REQUIRE(result.boundary.size() == expected.size());
  }
}

TEST_CASE("ScaleDoesNotMatter") {
  const NamedCloud named = test::noisy_torus(2000, 0.35, 23);
  const std::vector<Triangle> expected = reconstruct(named, {1.0, 1.5}).triangles;
  for (const double scale : {1e-6, 1e6, 0x1p-60}) {
    NamedCloud scaled = named;
    scaled.ball_radius *= scale;
    for (Vec3& p : scaled.cloud.positions) p = scale * p;
    INFO(scale);
    REQUIRE(reconstruct(scaled, {1.0, 1.5}).triangles == expected);
  }
}

TEST_CASE("RigidMotionDoesNotMatter") {
  const NamedCloud named = test::noisy_torus(2000, 0.35, 29);
  const std::vector<Triangle> expected = reconstruct(named, {1.0, 1.5}).triangles;
  const double c = std::cos(0.7), s = std::sin(0.7);
  const auto turned = [&](Vec3 v) { return Vec3{c * v.x - s * v.z, v.y, s * v.x + c * v.z}; };
  NamedCloud moved = named;
  for (Vec3& p : moved.cloud.positions) p = turned(p) + Vec3{3.0, -2.0, 11.0};
  for (Vec3& n : moved.cloud.normals) n = turned(n);
  REQUIRE(reconstruct(moved, {1.0, 1.5}).triangles == expected);
}

TEST_CASE("UtmCoordinatesDoNotMatter") {
  const NamedCloud named = test::noisy_torus(2000, 0.35, 31);
  const Vec3 offset{432'100.0, 4'612'345.0, 812.0};
  NamedCloud moved = named;
  for (Vec3& p : moved.cloud.positions) p = p + offset;
  REQUIRE(reconstruct(moved).triangles == reconstruct(named).triangles);
}

TEST_CASE("DifferencesOfPositionsDoNotDependOnTheOrigin") {
  const NamedCloud named = test::noisy_torus(500, 0.35, 37);
  const double step = lattice_step({{named.ball_radius}});
  const auto near = general_position(named.cloud.positions, {}, step);
  for (const Vec3 place : {Vec3{0.1, 0.2, 0.3}, Vec3{-5.0, 7.0, 11.0}}) {
    const Vec3 origin = on_lattice(place, step);
    const CellSpace at_zero(named.ball_radius, step, {}),
        at_origin(named.ball_radius, step, origin);
    const auto far = general_position(named.cloud.positions, origin, step);
    for (std::size_t i = 1; i < near.size(); ++i) {
      REQUIRE(far[i] - far[0] == near[i] - near[0]);
      for (int axis = 0; axis < 3; ++axis)
        REQUIRE(at_origin.along(far[i][axis], axis) - at_origin.along(far[0][axis], axis) ==
                at_zero.along(near[i][axis], axis) - at_zero.along(near[0][axis], axis));
    }
  }
}

namespace {

void check_same(const BallPivotingResult& result, const BallPivotingResult& expected) {
  CHECK(result.triangles == expected.triangles);
  CHECK(result.fans == expected.fans);
  CHECK(result.boundary == expected.boundary);
  CHECK(result.fan_members == expected.fan_members);
  CHECK(result.conflicts_lost == expected.conflicts_lost);
  CHECK(result.isolated_dropped == expected.isolated_dropped);
}

}  // namespace

TEST_CASE("PartsMakeTheWhole", "[slow]") {
  for (const double noise : {0.3, 0.7}) {
    const NamedCloud named = test::noisy_torus(30'000, noise, 41);
    const std::vector<double> radii = {named.ball_radius, 1.3 * named.ball_radius};
    const BallPivotingOptions options{radii};
    const PivotInput input{named.cloud.positions, named.cloud.normals, {}};
    const BallPivotingResult expected = reconstruct(named, {1.0, 1.3});
    for (const double most_radii : {60.0, 40.0}) {
      std::size_t parts = 0;
      const auto result =
          pivot_in_parts(input, halo_width(radii), most_radii * named.ball_radius,
                         [&](const PivotInput& part, const Box& box) {
                           ++parts;
                           CHECK(box.largest_extent() <= most_radii * named.ball_radius);
                           return ball_pivoting(part.positions, part.normals, part.owned, options);
                         });
      INFO(parts << " parts");
      CHECK(parts > 4);
      check_same(result, expected);
    }
  }
}

TEST_CASE("PartsOfAWallAndPointsFarFromItTakeMemoryForTheWholeAlone") {
  // More than half of the points have the smallest coordinate.
  std::vector<Vec3> positions, normals;
  constexpr std::size_t kWall = 15'000, kLone = 12'000;
  for (std::size_t i = 0; i < kWall; ++i)
    positions.push_back({0.0, static_cast<double>(i % 120), static_cast<double>(i / 120)});
  for (std::size_t i = 1; i <= kLone; ++i)
    positions.push_back({20.0 * static_cast<double>(i), 0.0, 0.0});
  normals.assign(positions.size(), Vec3{1, 0, 0});
  const std::uint64_t before = peak_memory_bytes();
  std::size_t parts = 0, owned = 0;
  const auto result =
      pivot_in_parts({positions, normals, {}}, 8.0, 100.0, [&](const PivotInput& part, const Box&) {
        ++parts;
        owned += static_cast<std::size_t>(std::count(part.owned.begin(), part.owned.end(), 1));
        BallPivotingResult none;
        none.fans.assign(part.positions.size(), 0);
        return none;
      });
  CHECK(owned == positions.size());
  CHECK(parts < positions.size());
  CHECK(peak_memory_bytes() - before < 30'000'000);
}

TEST_CASE("RadiiAsFarApartAsMayBeAreReconstructedWhateverTheExtent") {
  // The small balls close nothing; the cells of their grid are what is many.
  const NamedCloud named = test::noisy_torus(1000, 0.0, 1);
  const auto triangles_with = [&](double ratio) {
    const BallPivotingOptions options{{named.ball_radius / ratio, named.ball_radius}};
    return ball_pivoting(named.cloud.positions, named.cloud.normals, {}, options).triangles;
  };
  const std::vector<Triangle> expected = triangles_with(1000.0);
  CHECK(expected.size() == 2 * named.cloud.size());
  for (const double ratio : {20'000.0, 27'000.0, 52'000.0, 65'536.0}) {
    INFO(ratio);
    CHECK(triangles_with(ratio) == expected);
  }
  // The widest halo that radii may have fits into a part.
  NamedCloud far = named;
  far.cloud.positions.push_back({1e7, 1e3, 0.0});
  far.cloud.normals.push_back({0, 0, 1});
  const double r = named.ball_radius / 65'536.0;
  const BallPivotingOptions widest{{r, 65'000.0 * r, named.ball_radius}};
  CHECK(!ball_pivoting(far.cloud.positions, far.cloud.normals, {}, widest).triangles.empty());
}

TEST_CASE("NoPointsAreNoTriangles") {
  const BallPivotingResult result = ball_pivoting({}, {}, {}, {.ball_radii = {1.0}});
  CHECK(result.triangles.empty());
  CHECK(result.fans.empty());
  CHECK(result.boundary.empty());
}

TEST_CASE("RadiiThatCannotBeComputedWithAreRefused") {
  const NamedCloud named = test::noisy_torus(100, 0.0, 1);
  for (const std::vector<double>& radii : {std::vector<double>{},
                                           {0.0},
                                           {2.0, 1.0},
                                           {1e-300},
                                           {1e-320},
                                           {1e-76, 1.0},
                                           {1e76},
                                           {1.0, 65'537.0},
                                           {1.0, 65'534.0, 65'535.0, 65'536.0}})
    CHECK_THROWS_AS(ball_pivoting(named.cloud.positions, named.cloud.normals, {}, {radii}), Error);
}

TEST_CASE("CloudsFarApartAreReconstructedAsIfAlone") {
  const NamedCloud alone = test::noisy_torus(1000, 0.35, 43);
  const auto n = static_cast<std::uint32_t>(alone.cloud.positions.size());
  const std::vector<Triangle> triangles = reconstruct(alone, {1.0, 1.5}).triangles;
  REQUIRE(!triangles.empty());
  for (const double away : {1e4, 1e9}) {
    NamedCloud both = alone;
    for (const Vec3& p : alone.cloud.positions)
      both.cloud.positions.push_back(p + Vec3{away, 0.0, 0.0});
    both.cloud.normals.insert(both.cloud.normals.end(), alone.cloud.normals.begin(),
                              alone.cloud.normals.end());
    std::vector<Triangle> expected = triangles;
    for (const Triangle& t : triangles) expected.push_back({t[0] + n, t[1] + n, t[2] + n});
    CHECK(reconstruct(both, {1.0, 1.5}).triangles == expected);
  }
}

TEST_CASE("BadRadiiAreUsageErrors") {
  const NamedCloud named = test::grid_sheet(4, 0.0);
  for (const std::vector<double>& factors : {std::vector<double>{},
                                             {0.0},
                                             {-1.0},
                                             {2.0, 1.0},
                                             {1.0, 1.0},
                                             {1.0, 1e6},
                                             {std::nan("")},
                                             {INFINITY}}) {
    REQUIRE_THROWS_AS(reconstruct(named, factors), Error);
  }
}

}  // namespace orbweave
