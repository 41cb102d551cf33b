// The power test of five balls against integers, which are exact.
#include "engine/voronoi/power_side.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <random>

using namespace orbweave;
using voronoi::certain_power_sign;
using voronoi::WeightedVec;

namespace {

__extension__ using Wide = __int128;

struct IntegerBall {
  std::array<std::int64_t, 3> center{};
  std::int64_t weight = 0;
};

using IntegerBalls = std::array<IntegerBall, 5>;

Wide determinant(const std::array<std::array<Wide, 4>, 4>& m) {
  const auto minor = [&](std::size_t i, std::size_t j, std::size_t k) {
    return m[i][0] * (m[j][1] * m[k][2] - m[k][1] * m[j][2]) -
           m[j][0] * (m[i][1] * m[k][2] - m[k][1] * m[i][2]) +
           m[k][0] * (m[i][1] * m[j][2] - m[j][1] * m[i][2]);
  };
  return -m[0][3] * minor(1, 2, 3) + m[1][3] * minor(0, 2, 3) - m[2][3] * minor(0, 1, 3) +
         m[3][3] * minor(0, 1, 2);
}

/// Minus the sign of the determinant whose rows are the balls seen from the fifth one.
int exact_sign(const IntegerBalls& balls) {
  std::array<std::array<Wide, 4>, 4> rows{};
  for (std::size_t i = 0; i < 4; ++i) {
    rows[i][3] = balls[4].weight - balls[i].weight;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      rows[i][axis] = balls[i].center[axis] - balls[4].center[axis];
      rows[i][3] += rows[i][axis] * rows[i][axis];
    }
  }
  const Wide value = determinant(rows);
  return value < 0 ? 1 : value > 0 ? -1 : 0;
}

/// The balls as doubles, moved and scaled by powers of two: every number stays exact.
std::array<WeightedVec, 5> in_doubles(const IntegerBalls& balls, double origin, double scale) {
  std::array<WeightedVec, 5> result;
  for (std::size_t i = 0; i < 5; ++i) {
    for (int axis = 0; axis < 3; ++axis)
      result[i].position[axis] =
          scale * (origin + static_cast<double>(balls[i].center[static_cast<std::size_t>(axis)]));
    result[i].weight = scale * scale * static_cast<double>(balls[i].weight);
  }
  return result;
}

class RandomBalls {
 public:
  std::int64_t number(std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(-most, most)(bits_);
  }
  IntegerBalls any() {
    IntegerBalls balls;
    for (IntegerBall& ball : balls) {
      for (std::int64_t& x : ball.center) x = number(kMost);
      ball.weight = number(kMost * kMost);
    }
    return balls;
  }
  /// All through the origin but for `off` in one weight.
  IntegerBalls through_one_point(std::int64_t off) {
    IntegerBalls balls = any();
    for (IntegerBall& ball : balls) {
      ball.weight = 0;
      for (const std::int64_t x : ball.center) ball.weight += x * x;
    }
    balls[static_cast<std::size_t>(number(2) + 2)].weight += off;
    return balls;
  }

 private:
  static constexpr std::int64_t kMost = 1 << 16;
  std::mt19937_64 bits_{7};
};

}  // namespace

TEST_CASE("The power test is right for any balls, moved and scaled") {
  RandomBalls random;
  int certain = 0;
  for (int i = 0; i < 20'000; ++i) {
    const IntegerBalls balls = random.any();
    const int sign = exact_sign(balls);
    if (sign != 0) ++certain;
    REQUIRE(certain_power_sign(in_doubles(balls, 0.0, 1.0)) == sign);
    REQUIRE(certain_power_sign(in_doubles(balls, 0x1p30, 0x1p-20)) == sign);
    REQUIRE(certain_power_sign(in_doubles(balls, -0x1p33, 0x1p40)) == sign);
  }
  CHECK(certain > 19'000);
}

TEST_CASE("The power test tells balls through one point from balls that nearly are") {
  RandomBalls random;
  for (int i = 0; i < 20'000; ++i) {
    REQUIRE(certain_power_sign(in_doubles(random.through_one_point(0), 0x1p20, 0x1p-20)) == 0);
    for (const std::int64_t off : {-1, 1}) {
      const IntegerBalls balls = random.through_one_point(off);
      REQUIRE(certain_power_sign(in_doubles(balls, 0x1p20, 0x1p-20)) == exact_sign(balls));
    }
  }
}

TEST_CASE("The power test is not certain near the ends of the range of doubles") {
  RandomBalls random;
  const IntegerBalls balls = random.any();
  REQUIRE(certain_power_sign(in_doubles(balls, 0.0, 1.0)) != 0);
  CHECK(certain_power_sign(in_doubles(balls, 0.0, 0x1p-200)) == 0);
  CHECK(certain_power_sign(in_doubles(balls, 0.0, 0x1p200)) == 0);
  CHECK(certain_power_sign(in_doubles(balls, 0.0, 0x1p600)) == 0);
  std::array<WeightedVec, 5> unknown = in_doubles(balls, 0.0, 1.0);
  unknown[2].position.y = std::nan("");
  CHECK(certain_power_sign(unknown) == 0);
}
