// Walks that go among the nearest neighbours first find what walks among all find: the same
// corners in the same order, at every vector width, where decisions are as hard as they come.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "engine/ball_pivoting/cell_grid.h"
#include "engine/ball_pivoting/crowd_tree.h"
#include "engine/ball_pivoting/scratch_space.h"
#include "tests/support/clouds.h"
#include "tests/support/vector_widths.h"

namespace orbweave {
namespace {

using test::NamedCloud;
using test::Random;

/// Fans at all points of a cloud that is small enough for everybody to be a candidate.
class Fans {
 public:
  Fans(const NamedCloud& named, VectorWidth width, bool nearest_first) {
    const PointCloud& cloud = named.cloud;
    const auto n = static_cast<std::uint32_t>(cloud.positions.size());
    for (const auto axis : {0, 1, 2}) {
      for (const Vec3& p : cloud.positions) coordinates_[axis].push_back(p[axis]);
      coordinates_[axis].resize(n + kLanePadding, 0.0);
    }
    const PointArrays points = {coordinates_[0].data(), coordinates_[1].data(),
                                coordinates_[2].data(), cloud.normals.data()};
    CandidateRanges everybody;
    everybody.end[0] = n;
    everybody.count = 1;
    const WalkKernel kernel = walk_kernel(width);
    space_.grow(n);
    for (std::uint32_t first = 0; first < n; first += kWalksAtOnce) {
      const std::uint32_t count = std::min(kWalksAtOnce, n - first);
      for (std::uint32_t w = 0; w < count; ++w) {
        space_.arrays()[w].point = first + w;
        kernel.gather(points, everybody, named.ball_radius, space_.arrays()[w]);
      }
      settled += kernel.walk(points, space_.arrays(), count, nearest_first, space_.fans());
      for (std::uint32_t w = 0; w < count; ++w) {
        const Fan& fan = space_.fans()[w];
        text.push_back(fan.closed ? 1 : 0);
        text.push_back(fan.count);
        text.insert(text.end(), fan.corners, fan.corners + fan.count);
      }
    }
  }
  std::vector<std::uint64_t> text;  ///< closed, count, corners of all points
  std::size_t settled = 0;

 private:
  std::vector<double> coordinates_[3];
  ScratchSpace space_;
};

/// Returns how many fans the nearest neighbours settled.
std::size_t require_same_fans(const NamedCloud& named) {
  const Fans among_all(named, VectorWidth::kScalar, false);
  std::size_t settled = 0;
  for (const VectorWidth width : test::supported_widths()) {
    INFO(named.name << ", width " << static_cast<int>(width));
    REQUIRE(Fans(named, width, false).text == among_all.text);
    const Fans nearest_first(named, width, true);
    REQUIRE(nearest_first.text == among_all.text);
    settled += nearest_first.settled;
  }
  return settled;
}

void add(NamedCloud& named, Vec3 position, Vec3 normal) {
  named.cloud.positions.push_back(position);
  named.cloud.normals.push_back(normal);
}

/// Sheets of a lattice: rows `lean` steps further on from each other, `height` apart.
NamedCloud lattice(const std::string& name, double lean, double height, double radius) {
  NamedCloud named{name, {}, radius};
  for (int row = 0; row < 14; ++row) {
    for (int column = 0; column < 14; ++column) {
      const double x = column + lean * (row % 2);
      add(named, {x, height * row, 0.0}, {0.0, 0.0, 1.0});
    }
  }
  return named;
}

/// Layers of a cubic lattice, with normals to six sides.
NamedCloud cube_lattice(double radius) {
  NamedCloud named{"cube", {}, radius};
  for (int k = 0; k < 216; ++k) {
    const Vec3 p = {static_cast<double>(k % 6), static_cast<double>(k / 6 % 6),
                    static_cast<double>(k / 36)};
    Vec3 normal;
    normal[k % 3] = k % 2 == 0 ? 1.0 : -1.0;
    add(named, p, normal);
  }
  return named;
}

/// Rings of points on one ball, with its outward normals; one ball of that radius holds them all.
NamedCloud rings(double radius) {
  NamedCloud named{"rings", {}, radius};
  for (int ring = 1; ring < 8; ++ring) {
    for (int k = 0; k < 16; ++k) {
      const double polar = std::numbers::pi * ring / 8, around = std::numbers::pi * k / 8;
      const Vec3 p = {std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                      std::cos(polar)};
      add(named, p, p);
    }
  }
  return named;
}

/// Points around a hub, and one more that comes `short_of` as near to a ball of the fan as
/// touching.
NamedCloud wheel_with_a_threat(double short_of, Random& random) {
  NamedCloud named{"wheel", {}, 1.0};
  const auto spokes = static_cast<int>(5 + random.below(4));
  const double phase = random.uniform(), size = 0.35 + 0.3 * random.uniform();
  add(named, {}, {0.0, 0.0, 1.0});
  for (int k = 0; k < spokes; ++k) {
    const double around = 2.0 * std::numbers::pi * (k + phase) / spokes;
    add(named, {size * std::cos(around), size * std::sin(around), 0.0}, {0.0, 0.0, 1.0});
  }
  // The ball on the hub and two spokes stands over the middle of them all.
  const double between = 2.0 * std::numbers::pi * (phase + 0.5) / spokes;
  const double foot = 0.5 * size / std::cos(std::numbers::pi / spokes);
  const Vec3 centre = {foot * std::cos(between), foot * std::sin(between),
                       std::sqrt(1.0 - foot * foot)};
  Vec3 out = random.direction();
  if (out.z < 0.0) out.z = -out.z;
  add(named, centre + (1.0 + short_of) * out, {0.0, 0.0, 1.0});
  for (int k = 0; k < 20; ++k) {  // bystanders, that the threat is not among the nearest
    const double around = 2.0 * std::numbers::pi * (k + phase) / 20;
    add(named, {1.7 * std::cos(around), 1.7 * std::sin(around), -0.4}, {0.0, 0.0, 1.0});
  }
  return named;
}

/// Moves every point by up to `by` units along each axis, or by an ulp or two where `by` is 0.
NamedCloud jittered(NamedCloud named, double by, Random& random) {
  for (Vec3& p : named.cloud.positions) {
    for (int axis = 0; axis < 3; ++axis) {
      const double side = 2.0 * random.uniform() - 1.0;
      const double towards = side < 0.0 ? -10.0 : 10.0;
      p[axis] = by > 0.0 ? p[axis] + by * side : std::nextafter(p[axis], towards);
    }
  }
  return named;
}

NamedCloud scaled_and_moved(NamedCloud named, double scale, Vec3 by) {
  for (Vec3& p : named.cloud.positions) p = scale * p + by;
  named.ball_radius *= scale;
  return named;
}

std::vector<NamedCloud> lattices() {
  const double hexagonal = std::sqrt(0.75);
  return {lattice("square", 0.0, 1.0, 1.3),
          lattice("hexagonal", 0.5, hexagonal, 1.3),
          lattice("square, many near", 0.0, 1.0, 2.5),
          lattice("rectangles", 0.5, 0.6, 1.0),
          cube_lattice(0.9),
          cube_lattice(1.25),
          rings(0.5),
          rings(1.0),
          rings(1.0 + 1e-12)};
}

constexpr std::uint64_t kSeeds = 2;

}  // namespace

TEST_CASE("NeighboursThatMatterInACrowdFindWhatAllFind", "[costly]") {
  std::size_t taken = 0;
  const auto require_same_fans_of_crowd = [&](const NamedCloud& named) {
    const auto n = static_cast<std::uint32_t>(named.cloud.positions.size());
    const double step = std::exp2(-40.0);
    std::vector<Vec3> local;
    for (const Vec3& p : named.cloud.positions) {
      local.emplace_back();
      for (const auto axis : {0, 1, 2}) local.back()[axis] = std::round(p[axis] / step) * step;
    }
    const CellGrid grid(local, named.cloud.normals, CellSpace(named.ball_radius, step, {}));
    const CrowdTree tree(grid);
    CandidateRanges everybody;
    everybody.end[0] = n;
    everybody.count = 1;
    ScratchSpace space;
    space.grow(std::max(n, kMostOfCrowd));
    for (const VectorWidth width : test::supported_widths()) {
      const WalkKernel kernel = walk_kernel(width);
      for (std::uint32_t point = 0; point < n; point += 29) {
        WalkScratch* const scratch = space.arrays();
        scratch[0].point = scratch[1].point = point;
        kernel.gather(grid.arrays(), everybody, named.ball_radius, scratch[0]);
        if (!kernel.gather_crowd(grid.arrays(), tree.groups(), named.ball_radius, scratch[1]))
          continue;
        ++taken;
        REQUIRE(scratch[1].count <= kMostOfCrowd);
        kernel.walk(grid.arrays(), scratch, 2, false, space.fans());
        const Fan &among_all = space.fans()[0], &among_few = space.fans()[1];
        INFO(named.name << ", width " << static_cast<int>(width) << ", point " << point);
        REQUIRE(among_few.closed == among_all.closed);
        REQUIRE(among_few.blocked == among_all.blocked);
        REQUIRE(std::equal(among_few.corners, among_few.corners + among_few.count,
                           among_all.corners, among_all.corners + among_all.count));
      }
    }
  };
  for (const bool on_sphere : {false, true}) {
    for (const double width : {1e-5, 0.02, 0.2}) {
      NamedCloud named = test::sphere_with_crowd(300, 2500, width, on_sphere, 11);
      named.ball_radius = 0.25;
      require_same_fans_of_crowd(named);
    }
  }
  NamedCloud torus = test::noisy_torus(3000, 0.5, 12);
  torus.ball_radius *= 6.0;
  require_same_fans_of_crowd(torus);
  NamedCloud ball = test::random_ball(3000, 13);
  ball.ball_radius *= 3.0;
  require_same_fans_of_crowd(ball);
  CHECK(taken > 1500);
}

TEST_CASE("NearestFirstChangesNothingOnLatticesHoweverLittleTheyAreMoved", "[costly]") {
  std::size_t settled = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Random random(seed);
    for (const NamedCloud& named : lattices()) {
      settled += require_same_fans(named);
      for (const double by : {0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-4, 1e-2, 0.3}) {
        settled += require_same_fans(jittered(named, by, random));
      }
    }
  }
  REQUIRE(settled > 0);
}

TEST_CASE("NearestFirstChangesNothingWhereAPointJustReachesTheBall", "[costly]") {
  std::size_t settled = 0;
  for (std::uint64_t seed = 0; seed < 40 * kSeeds; ++seed) {
    Random random(seed);
    // Around touching, around the margin of what is clear, and across all sizes of both signs.
    const double size = std::pow(10.0, -17.0 * random.uniform());
    for (const double short_of : {0.0, size, -size, 1e-4, 1e-4 + size, 1e-4 - size}) {
      settled += require_same_fans(wheel_with_a_threat(short_of, random));
    }
  }
  REQUIRE(settled > 0);
}

TEST_CASE("NearestFirstChangesNothingUnderNoise") {
  std::size_t settled = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    for (const double noise : {0.0, 0.1, 0.3, 0.6}) {
      settled += require_same_fans(test::noisy_torus(300, noise, seed));
    }
    settled += require_same_fans(test::random_sphere(150, seed));
    settled += require_same_fans(test::random_ball(100, seed));
  }
  REQUIRE(settled > 0);
}

TEST_CASE("NearestFirstChangesNothingAtAnyScaleOrPlace") {
  Random random(5);
  std::size_t settled = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const NamedCloud torus = test::noisy_torus(200, 0.1, seed);
    for (const double scale : {1e-300, 1e-150, 1e-80, 1e-3, 1e80, 1e150, 1e300}) {
      for (const NamedCloud& named : {torus, lattice("square", 0.0, 1.0, 1.3)}) {
        settled += require_same_fans(scaled_and_moved(named, scale, {}));
        settled += require_same_fans(scaled_and_moved(named, 1e-3, {4.5e5, 5.4e6, 1e7}));
      }
    }
  }
  REQUIRE(settled > 0);
}

TEST_CASE("NearestFirstChangesNothingWithDegenerateNormalsAndTwins") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Random random(seed);
    for (const double length : {0.0, 1e-200, 1e-160, 1e150, 1e200, nan}) {
      NamedCloud named = test::noisy_torus(200, 0.1, seed);
      for (Vec3& normal : named.cloud.normals) {
        if (random.below(2) == 0) normal = length * normal;
      }
      for (int k = 0; k < 20; ++k) {  // in the same place, or next to nothing away
        const Vec3 twin = named.cloud.positions[random.below(named.cloud.positions.size())];
        const double apart = k % 2 == 0 ? 0.0 : 1e-13;
        add(named, twin + apart * random.direction(), random.direction());
      }
      require_same_fans(named);
    }
  }
}

}  // namespace orbweave
