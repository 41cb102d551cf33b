#include "engine/normals/orientation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "engine/normals/estimate_normals.h"
#include "engine/normals/ground_patches.h"
#include "engine/normals/normals_from_faces.h"
#include "engine/normals/orientation_graph.h"
#include "io/meshes/mesh_reader.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"

namespace orbweave {
namespace {

struct Unoriented {
  std::vector<Vec3> positions, normals;
  std::vector<std::uint64_t> global;
};

Unoriented unoriented(const PointCloud& cloud, double radius) {
  const auto size = static_cast<std::uint32_t>(cloud.size());
  Unoriented out{cloud.positions, {}, {}};
  out.normals = estimate_normals(cloud.positions, 0, size, {16, radius}).normals;
  for (std::uint32_t i = 0; i < size; ++i) out.global.push_back(i);
  return out;
}

OrientedPatches patches_of(const Unoriented& cloud, const OrientationOptions& options) {
  return orient_patches(cloud.positions, cloud.normals, cloud.global, 0,
                        static_cast<std::uint32_t>(cloud.positions.size()), options);
}

std::vector<Vec3> oriented_normals(const Unoriented& cloud, const OrientationOptions& options,
                                   PatchOrientation* summary = nullptr,
                                   const PatchGraphOptions& graph = {}) {
  const OrientedPatches patches = patches_of(cloud, options);
  const PatchOrientation found = orient_patch_graph(patches.sums, patches.votes, graph);
  std::vector<Vec3> normals = cloud.normals;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const auto at =
        std::lower_bound(found.patches.begin(), found.patches.end(), patches.patch_of[i]);
    if (at == found.patches.end() || *at != patches.patch_of[i]) continue;
    if (patches.turn[i] ^ found.turn[at - found.patches.begin()]) normals[i] = -normals[i];
  }
  if (summary != nullptr) *summary = found;
  return normals;
}

double agreeing(const std::vector<Vec3>& normals, const std::vector<Vec3>& truth) {
  std::size_t agree = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) agree += dot(normals[i], truth[i]) > 0.0;
  return static_cast<double>(agree) / static_cast<double>(normals.size());
}

/// Cells of about 200 points for points at distances of `spacing`.
OrientationOptions options_for(double spacing) {
  return {std::exp2(std::round(std::log2(14.0 * spacing))), 10, 6.0 * spacing};
}

/// Points in the box of [begin, end), widened by the halo, and where the owned ones begin.
struct Part {
  Unoriented cloud;
  std::uint32_t begin = 0;
};

Part part_of(const Unoriented& whole, std::uint32_t begin, std::uint32_t end, double halo) {
  Vec3 low = whole.positions[begin], high = low;
  for (std::uint32_t i = begin; i < end; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], whole.positions[i][axis]);
      high[axis] = std::max(high[axis], whole.positions[i][axis]);
    }
  Part part;
  for (std::uint32_t i = 0; i < whole.positions.size(); ++i) {
    const Vec3 p = whole.positions[i];
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis)
      inside = inside && p[axis] >= low[axis] - halo && p[axis] <= high[axis] + halo;
    if (i == begin) part.begin = static_cast<std::uint32_t>(part.cloud.positions.size());
    if (!inside) continue;
    part.cloud.positions.push_back(p);
    part.cloud.normals.push_back(whole.normals[i]);
    part.cloud.global.push_back(whole.global[i]);
  }
  return part;
}

bool same(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }
bool same(Vec3 a, Vec3 b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void require_same(const OrientedPatches& a, const OrientedPatches& b) {
  REQUIRE(a.patch_of == b.patch_of);
  REQUIRE(a.turn == b.turn);
  REQUIRE(a.sums.size() == b.sums.size());
  for (std::size_t i = 0; i < a.sums.size(); ++i) {
    const PatchSum &s = a.sums[i], &t = b.sums[i];
    REQUIRE(s.patch == t.patch);
    REQUIRE(s.points == t.points);
    REQUIRE((same(s.lowest, t.lowest) && same(s.highest, t.highest)));
    REQUIRE((same(s.area_normal, t.area_normal) && same(s.flux, t.flux)));
    REQUIRE(same(s.flux_origin, t.flux_origin));
  }
  REQUIRE(a.votes.size() == b.votes.size());
  for (std::size_t i = 0; i < a.votes.size(); ++i) {
    REQUIRE((a.votes[i].from == b.votes[i].from && a.votes[i].to == b.votes[i].to));
    REQUIRE(
        (same(a.votes[i].votes, b.votes[i].votes) && same(a.votes[i].weight, b.votes[i].weight)));
  }
}

/// A rectangle from a corner along two edges, with points at distances of 1, moved by up to 0.3 in
/// its plane, and the same normal for all.
void add_wall(Vec3 corner, Vec3 along, Vec3 up, Vec3 normal, test::Random& random,
              PointCloud& cloud) {
  const double columns = norm(along), rows = norm(up);
  for (double i = 0.5; i < columns; i += 1.0)
    for (double k = 0.5; k < rows; k += 1.0) {
      const double s = (i + 0.6 * (random.uniform() - 0.5)) / columns;
      const double t = (k + 0.6 * (random.uniform() - 0.5)) / rows;
      cloud.positions.push_back(corner + s * along + t * up);
      cloud.normals.push_back(normal);
    }
}

/// A yard of 60 x 60 between walls of some height, seen from inside: normals point into it.
PointCloud yard(double height, bool has_ceiling) {
  constexpr double kSide = 60.0;
  test::Random random(5);
  PointCloud cloud;
  const Vec3 x{kSide, 0.0, 0.0}, y{0.0, kSide, 0.0}, z{0.0, 0.0, height};
  add_wall({}, x, y, {0.0, 0.0, 1.0}, random, cloud);
  add_wall({}, x, z, {0.0, 1.0, 0.0}, random, cloud);
  add_wall({}, y, z, {1.0, 0.0, 0.0}, random, cloud);
  add_wall(y, x, z, {0.0, -1.0, 0.0}, random, cloud);
  add_wall(x, y, z, {-1.0, 0.0, 0.0}, random, cloud);
  if (has_ceiling) add_wall(z, x, y, {0.0, 0.0, -1.0}, random, cloud);
  return cloud;
}

OrientedPatches in_parts(const Unoriented& whole, const OrientationOptions& options,
                         std::uint32_t parts) {
  OrientedPatches out;
  const auto size = static_cast<std::uint32_t>(whole.positions.size());
  for (std::uint32_t k = 0; k < parts; ++k) {
    const auto begin = static_cast<std::uint32_t>(std::uint64_t{k} * size / parts);
    const auto end = static_cast<std::uint32_t>((std::uint64_t{k} + 1) * size / parts);
    const Part part = part_of(whole, begin, end, orientation_halo(options));
    const OrientedPatches found =
        orient_patches(part.cloud.positions, part.cloud.normals, part.cloud.global, part.begin,
                       part.begin + (end - begin), options);
    out.patch_of.insert(out.patch_of.end(), found.patch_of.begin(), found.patch_of.end());
    out.turn.insert(out.turn.end(), found.turn.begin(), found.turn.end());
    out.sums.insert(out.sums.end(), found.sums.begin(), found.sums.end());
    out.votes.insert(out.votes.end(), found.votes.begin(), found.votes.end());
  }
  const auto by_ids = [](const PatchVote& a, const PatchVote& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  };
  std::stable_sort(out.votes.begin(), out.votes.end(), by_ids);
  std::stable_sort(out.sums.begin(), out.sums.end(),
                   [](const PatchSum& a, const PatchSum& b) { return a.patch < b.patch; });
  return out;
}

}  // namespace

TEST_CASE("ClosedSurfacesEndOutward") {
  const test::NamedCloud torus = test::noisy_torus(20000, 0.2, 1);
  const test::NamedCloud sphere = test::random_sphere(8000, 2);
  for (const test::NamedCloud& named : {torus, sphere}) {
    const double spacing = named.ball_radius / 1.5;
    const Unoriented cloud = unoriented(named.cloud, 6.0 * spacing);
    PatchOrientation summary;
    const auto normals = oriented_normals(cloud, options_for(spacing), &summary);
    CAPTURE(named.name);
    CHECK(agreeing(normals, named.cloud.normals) == 1.0);
    CHECK(summary.components == 1);
    CHECK(summary.contested == 0);
    CHECK(summary.satisfied > 0.99);
  }
}

TEST_CASE("BothSidesOfAThinWallEndOutward") {
  // A box of 40 x 40 x 1 spacings but for its rim's corners: sheets back to back.
  PointCloud cloud;
  for (int i = 0; i <= 40; ++i)
    for (int j = 0; j <= 40; ++j)
      for (const double side : {-1.0, 1.0}) {
        const double x = i + 0.02 * ((i * 7 + j * 3) % 5), y = j + 0.02 * ((i * 5 + j) % 7);
        cloud.positions.push_back({x, y, side});
        cloud.normals.push_back({0, 0, side});
      }
  test::put_in_order(cloud);
  const Unoriented unknown = unoriented(cloud, 1.9);
  CHECK(agreeing(oriented_normals(unknown, {16.0, 16, 4.0}), cloud.normals) == 1.0);
}

TEST_CASE("PatchesOfPartsAreThoseOfTheWholeToTheLastBit", "[costly]") {
  const test::NamedCloud torus = test::noisy_torus(12000, 0.5, 7);
  const double spacing = torus.ball_radius / 1.5;
  Unoriented cloud = unoriented(torus.cloud, 6.0 * spacing);
  for (std::size_t i = 0; i < cloud.normals.size(); i += 97) cloud.normals[i] = {};
  for (const double cells : {0.25, 1.0}) {
    OrientationOptions options = options_for(spacing);
    options.cell *= cells;
    const OrientedPatches whole = patches_of(cloud, options);
    for (const std::uint32_t parts : {3u, 17u, 64u})
      require_same(in_parts(cloud, options, parts), whole);
  }
}

TEST_CASE("MovedAndCoincidingPointsHaveThePatchesOfTheWhole") {
  // As smoothing leaves them: no longer where their order has them, some at the same place.
  const test::NamedCloud torus = test::noisy_torus(8000, 0.3, 7);
  const double spacing = torus.ball_radius / 1.5;
  Unoriented cloud = unoriented(torus.cloud, 6.0 * spacing);
  test::Random random(3);
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    const double far = i % 20 == 0 ? 5.0 : 0.3;
    cloud.positions[i] = cloud.positions[i] + far * spacing * random.direction();
    if (i % 31 == 0 && i > 0) cloud.positions[i] = cloud.positions[i - 1];
  }
  const OrientationOptions options = options_for(spacing);
  const OrientedPatches whole = patches_of(cloud, options);
  for (const std::uint32_t parts : {3u, 17u}) require_same(in_parts(cloud, options, parts), whole);
}

TEST_CASE("PointsWithoutANormalTakeNoPart") {
  const test::NamedCloud torus = test::noisy_torus(3000, 0.1, 3);
  const double spacing = torus.ball_radius / 1.5;
  Unoriented cloud = unoriented(torus.cloud, 6.0 * spacing);
  cloud.normals[5] = cloud.normals[700] = {};
  const OrientedPatches patches = patches_of(cloud, options_for(spacing));
  for (const std::uint32_t i : {5u, 700u}) {
    CHECK(patches.patch_of[i] == i);
    CHECK(patches.turn[i] == 0);
    for (const PatchSum& s : patches.sums) CHECK(s.patch != i);
  }
  std::uint64_t points = 0;
  for (const PatchSum& s : patches.sums) points += s.points;
  CHECK(points == cloud.positions.size() - 2);
}

TEST_CASE("TheInputsSignsDoNotMatter") {
  const test::NamedCloud torus = test::noisy_torus(6000, 0.3, 3);
  const double spacing = torus.ball_radius / 1.5;
  Unoriented cloud = unoriented(torus.cloud, 6.0 * spacing);
  const auto before = oriented_normals(cloud, options_for(spacing));
  test::Random random(8);
  for (Vec3& n : cloud.normals)
    if (random.below(2) == 1) n = -n;
  CHECK(oriented_normals(cloud, options_for(spacing)) == before);
}

TEST_CASE("ScaleAndOffsetDoNotChangeTheSigns") {
  test::NamedCloud torus = test::noisy_torus(5000, 0.2, 6);
  const double spacing = torus.ball_radius / 1.5;
  for (Vec3& p : torus.cloud.positions)
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::round(p[axis] * 0x1p20) * 0x1p-20;
  for (const double scale : {1e-6, 1.0, 1e6}) {
    PointCloud moved = torus.cloud;
    for (Vec3& p : moved.positions) p = scale * (p + Vec3{691000.0, 5334000.0, 512.0});
    const Unoriented cloud = unoriented(moved, 6.0 * scale * spacing);
    const auto normals = oriented_normals(cloud, options_for(scale * spacing));
    CHECK(agreeing(normals, torus.cloud.normals) == 1.0);
  }
}

TEST_CASE("SeparateComponentsEachEndOutward") {
  const test::NamedCloud sphere = test::random_sphere(4000, 2);
  PointCloud both = sphere.cloud;
  for (std::size_t i = 0; i < sphere.cloud.size(); ++i) {
    both.positions.push_back(sphere.cloud.positions[i] + Vec3{50.0, 3.0, -7.0});
    both.normals.push_back(sphere.cloud.normals[i]);
  }
  test::put_in_order(both);
  const double spacing = sphere.ball_radius / 1.5;
  const Unoriented cloud = unoriented(both, 6.0 * spacing);
  PatchOrientation summary;
  CHECK(agreeing(oriented_normals(cloud, options_for(spacing), &summary), both.normals) == 1.0);
  CHECK(summary.components == 2);
}

TEST_CASE("AFlatSheetHasOneSignAndItPointsUp") {
  const test::NamedCloud sheet = test::grid_sheet(50, 0.0);
  const double spacing = norm(sheet.cloud.positions[1] - sheet.cloud.positions[0]);
  const Unoriented cloud = unoriented(sheet.cloud, 6.0 * spacing);
  const auto normals = oriented_normals(cloud, options_for(spacing));
  for (const Vec3& n : normals) REQUIRE(n.z > 0.0);
}

TEST_CASE("AValleyPointsUpThoughItsNormalsMeetInside") {
  test::NamedCloud sheet = test::grid_sheet(60, 0.0);
  const double spacing = norm(sheet.cloud.positions[1] - sheet.cloud.positions[0]);
  const Vec3 center =
      sheet.cloud.bounds().min + 0.5 * (sheet.cloud.bounds().max - sheet.cloud.bounds().min);
  const double side = sheet.cloud.bounds().largest_extent();
  for (Vec3& p : sheet.cloud.positions) {
    const double across = (p.x - center.x) / side, along = (p.y - center.y) / side;
    p.z = 0.8 * side * (across * across + along * along);
  }
  const Unoriented cloud = unoriented(sheet.cloud, 6.0 * spacing);
  for (const Vec3& n : oriented_normals(cloud, options_for(spacing))) REQUIRE(n.z > 0.0);
}

TEST_CASE("NeighboursOfFarLinesVoteWhereTheNearestAreAllOfOneLine") {
  // Lines 24 times as far apart as the points on them, every other one with its normals turned.
  PointCloud cloud;
  for (int line = 0; line < 12; ++line)
    for (int i = 0; i < 200; ++i) cloud.positions.push_back({1.0 * i, 24.0 * line, 0.0});
  test::put_in_order(cloud);
  Unoriented lines{cloud.positions, {}, {}};
  for (const Vec3& p : cloud.positions) {
    lines.normals.push_back({0.0, 0.0, std::fmod(p.y, 48.0) < 1.0 ? 1.0 : -1.0});
    lines.global.push_back(lines.global.size());
  }
  OrientationOptions options{.cell = 16.0, .max_radius = 40.0};
  const auto facing_up = [&] {
    const std::vector<Vec3> normals = oriented_normals(lines, options);
    return std::ranges::count_if(normals, [](const Vec3& n) { return n.z > 0.0; });
  };
  options.among = 64;
  CHECK(facing_up() == static_cast<std::ptrdiff_t>(cloud.size()));
  const OrientedPatches joined = patches_of(lines, options);
  CHECK(orient_patch_graph(joined.sums, joined.votes, {}).components == 1);
}

TEST_CASE("RingsAroundTheAxisOfAScannerTakeTheSideOfTheSurface") {
  // Parallels and meridians of a ball, two degrees apart: near the poles the points of a ring are
  // so close together that the nearest neighbours are all of that ring.
  constexpr int kAlong = 180, kRings = 90;
  PointCloud ball;
  for (int ring = 1; ring < kRings; ++ring)
    for (int i = 0; i < kAlong; ++i) {
      const double latitude = std::numbers::pi * (1.0 * ring / kRings - 0.5);
      const double longitude = 2.0 * std::numbers::pi * i / kAlong;
      ball.positions.push_back({std::cos(latitude) * std::cos(longitude),
                                std::cos(latitude) * std::sin(longitude), std::sin(latitude)});
    }
  test::put_in_order(ball);
  Unoriented rings{ball.positions, {}, {}};
  for (const Vec3& p : ball.positions) {
    rings.normals.push_back(p.x + 0.3 * p.y > 0.1 * p.z ? p : -p);
    rings.global.push_back(rings.global.size());
  }
  const OrientationOptions options{.cell = 0.25, .max_radius = 0.2};
  const std::vector<Vec3> normals = oriented_normals(rings, options);
  for (std::size_t i = 0; i < normals.size(); ++i)
    REQUIRE(dot(normals[i], ball.positions[i]) > 0.0);
}

TEST_CASE("VotesAreJoinedFromTheSurestDown") {
  // 0 and 1 agree strongly, 1 and 2 oppose; the weak vote of 0 and 2 is overruled.
  const std::vector<SignedEdge> edges = {{0, 1, 9, 9}, {2, 1, -5, 5}, {0, 2, 3, 3}};
  const SignedParts parts = join_by_votes(4, edges);
  CHECK(parts.part == std::vector<std::uint32_t>{0, 0, 0, 3});
  CHECK(parts.turn == std::vector<std::uint8_t>{0, 0, 1, 0});
  // Together they overrule it: 0 and 1 join first, then their votes on 2 add up.
  const SignedParts sum = join_by_votes(3, {{0, 1, 9, 9}, {1, 2, -5, 5}, {0, 2, 6, 6}});
  CHECK(sum.turn == std::vector<std::uint8_t>{0, 0, 0});
  const SignedParts cautious =
      join_by_votes(3, {{0, 1, 9, 9}, {1, 2, -5, 5}, {0, 2, 6, 6}}, {.least_share = 0.5});
  CHECK(cautious.part == std::vector<std::uint32_t>{0, 0, 2});
}

TEST_CASE("LongChainsOfPatchesAreSignedAlongTheirWholeLength", "[costly]") {
  // A corridor of patches, joined from one end to the other: every third link turns.
  constexpr std::uint32_t kNodes = 300000;
  for (const bool rising : {false, true}) {
    std::vector<SignedEdge> edges;
    std::vector<std::uint8_t> turn(1, 0);
    for (std::uint32_t i = 0; i + 1 < kNodes; ++i) {
      const double size = kNodes + (rising ? i : kNodes - i);
      edges.push_back({i, i + 1, i % 3 == 0 ? -size : size, size});
      turn.push_back(turn.back() ^ (i % 3 == 0 ? 1 : 0));
    }
    const SignedParts parts = join_by_votes(kNodes, std::move(edges));
    CHECK(parts.part == std::vector<std::uint32_t>(kNodes, 0));
    CHECK(parts.turn == turn);
  }
}

TEST_CASE("TheOrderOfRowsDoesNotMatter") {
  const test::NamedCloud torus = test::noisy_torus(6000, 0.8, 5);
  const double spacing = torus.ball_radius / 1.5;
  OrientationOptions options = options_for(spacing);
  options.cell *= 0.25;
  const OrientedPatches patches = patches_of(unoriented(torus.cloud, 6.0 * spacing), options);
  const PatchOrientation once = orient_patch_graph(patches.sums, patches.votes);
  std::vector<PatchSum> sums(patches.sums.rbegin(), patches.sums.rend());
  std::vector<PatchVote> votes(patches.votes.rbegin(), patches.votes.rend());
  const PatchOrientation again = orient_patch_graph(sums, votes);
  CHECK(again.patches == once.patches);
  CHECK(again.turn == once.turn);
  CHECK(same(again.satisfied, once.satisfied));
  CHECK(again.contested == once.contested);
}

TEST_CASE("TheGroundOfAYardFacesUpAndItsWallsFollow") {
  const PointCloud cloud = yard(130.0, false);
  const OrientationOptions options = options_for(1.0);
  const Unoriented scan = unoriented(cloud, 6.0);
  // Such high walls enclose: without a word for the ground the yard is a thing seen from outside.
  CHECK(agreeing(oriented_normals(scan, options), cloud.normals) < 0.05);
  PatchOrientation summary;
  const PatchGraphOptions graph{.ground = true, .cell = options.cell};
  CHECK(agreeing(oriented_normals(scan, options, &summary, graph), cloud.normals) > 0.95);
  CHECK(summary.ground > 4);
  CHECK(summary.ground_down == 0);
}

TEST_CASE("UpIsWhereTheOptionSays") {
  PointCloud cloud = yard(130.0, false);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (Vec3* v : {&cloud.positions[i], &cloud.normals[i]}) *v = {v->x, -v->z, v->y};
  const OrientationOptions options = options_for(1.0);
  const PatchGraphOptions graph{.ground = true, .up = {0.0, -1.0, 0.0}, .cell = options.cell};
  const auto normals = oriented_normals(unoriented(cloud, 6.0), options, nullptr, graph);
  CHECK(agreeing(normals, cloud.normals) > 0.95);
}

TEST_CASE("ARoomPointsInwardWhereThatIsAsked") {
  const PointCloud cloud = yard(40.0, true);
  const OrientationOptions options = options_for(1.0);
  const Unoriented scan = unoriented(cloud, 6.0);
  CHECK(agreeing(oriented_normals(scan, options), cloud.normals) < 0.05);
  CHECK(agreeing(oriented_normals(scan, options, nullptr, {.inward = true}), cloud.normals) > 0.95);
  const PatchGraphOptions ground{.ground = true, .cell = options.cell};
  CHECK(agreeing(oriented_normals(scan, options, nullptr, ground), cloud.normals) > 0.95);
}

TEST_CASE("OnlyWhatNothingLiesBelowIsGround") {
  constexpr double kCell = 16.0;
  std::vector<PatchSum> sums;
  const auto add = [&](Vec3 center, Vec3 normal, std::uint64_t points) {
    PatchSum sum;
    sum.patch = sums.size();
    sum.points = points;
    sum.lowest = center - Vec3{5.0, 5.0, 1.0};
    sum.highest = center + Vec3{5.0, 5.0, 1.0};
    sum.area_normal = 100.0 * normal;
    sums.push_back(sum);
    return sums.size() - 1;
  };
  const Vec3 up{0.0, 0.0, 1.0};
  // A slope of 0.4, 20 by 20 cells.
  for (int i = 0; i < 400; ++i)
    add({kCell * (i % 20), kCell * (i / 20), 0.4 * kCell * (i % 20)}, up, 200);
  const std::size_t table = add({160.0, 160.0, 64.0 + 50.0}, -up, 200);
  const std::size_t roof = add({80.0, 80.0, 32.0 + 150.0}, up, 200);
  const std::size_t wall = add({400.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, 200);
  const std::size_t speck = add({100.0, 100.0, -300.0}, up, 3);
  const std::size_t far = add({5000.0, 5000.0, 400.0}, -up, 200);
  const auto is_ground = find_ground(sums, kCell, up);
  for (std::size_t i = 0; i < 400; ++i) {
    INFO("patch " << i);
    REQUIRE(is_ground[i] == 1);
  }
  CHECK(is_ground[table] == 0);
  CHECK(is_ground[roof] == 0);
  CHECK(is_ground[wall] == 0);
  CHECK(is_ground[speck] == 0);
  CHECK(is_ground[far] == 1);
}

TEST_CASE("ABallThatHidesTheFloorBelowItselfFacesOutwardOnTheGround") {
  constexpr double kRadius = 45.0, kSide = 250.0;
  test::Random random(5);
  PointCloud floor;
  const Vec3 corner{-0.5 * kSide, -0.5 * kSide, 0.0};
  add_wall(corner, {kSide, 0.0, 0.0}, {0.0, kSide, 0.0}, {0.0, 0.0, 1.0}, random, floor);
  PointCloud cloud;
  const auto add = [&](Vec3 position, Vec3 normal) {
    cloud.positions.push_back(position);
    cloud.normals.push_back(normal);
  };
  // Scanners around see neither the floor below the ball nor its lowest part.
  for (const Vec3 p : floor.positions)
    if (std::hypot(p.x, p.y) > 0.8 * kRadius) add(p, {0.0, 0.0, 1.0});
  const test::NamedCloud ball = test::random_sphere(25'447, 2);  // of radius 1
  for (const Vec3 n : ball.cloud.normals)
    if (n.z > -0.8) add(kRadius * (n + Vec3{0.0, 0.0, 1.0}), n);
  const OrientationOptions options = options_for(1.0);
  PatchOrientation summary;
  const PatchGraphOptions graph{.ground = true, .cell = options.cell};
  const auto normals = oriented_normals(unoriented(cloud, 6.0), options, &summary, graph);
  CHECK(agreeing(normals, cloud.normals) > 0.99);
  CHECK(summary.ground > 100);
  CHECK(summary.ground_down == 0);
}

TEST_CASE("SparsePatchesOfTheGroundAreGroundAndWhatStandsOnThemIsNot") {
  constexpr double kCell = 16.0;
  std::vector<PatchSum> sums;
  const auto add = [&](Vec3 center, std::uint64_t points) {
    PatchSum sum;
    sum.patch = sums.size();
    sum.points = points;
    sum.lowest = sum.highest = center;
    sum.area_normal = {0.0, 0.0, 100.0};
    sums.push_back(sum);
  };
  for (int i = 0; i < 100; ++i) add({kCell * (i % 10) + 1.0, kCell * (i / 10) + 1.0, 0.0}, 5);
  add({73.0, 73.0, 120.0}, 6);
  const auto is_ground = find_ground(sums, kCell, {0.0, 0.0, 1.0});
  for (std::size_t i = 0; i < 100; ++i) REQUIRE(is_ground[i] == 1);
  CHECK(is_ground[100] == 0);
}

TEST_CASE("ContestedPlacesAreThoseWithTheMostContestedPatches") {
  // Rings of three patches that contradict each other: four rings at x = 1, two at x = 99.
  std::vector<PatchSum> sums;
  std::vector<PatchVote> votes;
  for (int ring = 0; ring < 6; ++ring) {
    const std::uint64_t first = sums.size();
    for (std::uint64_t k = 0; k < 3; ++k) {
      PatchSum sum;
      sum.patch = first + k;
      sum.points = 200;
      sum.lowest = sum.highest = {ring < 4 ? 1.0 : 99.0, 1.0, 1.0};
      sums.push_back(sum);
      votes.push_back({first + k, first + (k + 1) % 3, -1.0, 1.0});
    }
  }
  const PatchOrientation found = orient_patch_graph(sums, votes);
  REQUIRE(found.places.size() == 2);
  CHECK(found.places[0].patches > found.places[1].patches);
  CHECK(found.places[0].patches + found.places[1].patches == found.contested);
  CHECK(std::abs(found.places[0].center.x - 1.0) < 8.0);
  CHECK(std::abs(found.places[1].center.x - 99.0) < 8.0);
}

TEST_CASE("ContradictingVotesAreReported") {
  std::vector<PatchSum> sums(3);
  for (std::uint64_t i = 0; i < 3; ++i) sums[i].patch = 10 * i;
  const PatchOrientation found =
      orient_patch_graph(sums, {{0, 10, 4, 4}, {10, 20, 3, 3}, {20, 0, -2, 2}});
  CHECK(found.components == 1);
  CHECK(found.contested == 2);
  CHECK(found.satisfied == Approx(7.0 / 9.0));
  CHECK(orient_patch_graph({}, {}).patches.empty());
}

TEST_CASE("TheBunnysNormalsEndOutward") {
  const auto path = test::data_path("stanford/bun_zipper.ply");
  if (test::skipped_without(path)) return;
  TriangleMesh mesh = read_mesh(path);
  PointCloud cloud;
  cloud.positions = mesh.vertices.positions;
  cloud.normals = normals_from_faces(mesh);
  test::put_in_order(cloud);
  const double spacing = 0.00115;
  const Unoriented unknown = unoriented(cloud, 6.0 * spacing);
  CHECK(agreeing(oriented_normals(unknown, options_for(spacing)), cloud.normals) > 0.999);
}

}  // namespace orbweave
