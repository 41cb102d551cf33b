#include "engine/voronoi/power_side.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/voronoi/double_pair.h"

namespace orbweave::voronoi {
namespace {

/// A ball seen from the fifth one: its offset, and the difference of the squared offset and weight.
template <class Number>
struct Row {
  Number x{}, y{}, z{}, power{};
};

template <class Number>
using Rows = std::array<Row<Number>, 4>;

template <class Number>
Number determinant(const Rows<Number>& rows) {
  const auto minor = [&](std::size_t i, std::size_t j) {
    return rows[i].x * rows[j].y - rows[j].x * rows[i].y;
  };
  const Number m01 = minor(0, 1), m02 = minor(0, 2), m03 = minor(0, 3);
  const Number m12 = minor(1, 2), m13 = minor(1, 3), m23 = minor(2, 3);
  const Number m012 = m01 * rows[2].z - m02 * rows[1].z + m12 * rows[0].z;
  const Number m013 = m01 * rows[3].z - m03 * rows[1].z + m13 * rows[0].z;
  const Number m023 = m02 * rows[3].z - m03 * rows[2].z + m23 * rows[0].z;
  const Number m123 = m12 * rows[3].z - m13 * rows[2].z + m23 * rows[1].z;
  return (m012 * rows[3].power - m013 * rows[2].power) +
         (m023 * rows[1].power - m123 * rows[0].power);
}

Rows<double> rows_in_doubles(const std::array<WeightedVec, 5>& balls) {
  Rows<double> rows;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 d = balls[i].position - balls[4].position;
    rows[i] = {d.x, d.y, d.z, squared_norm(d) + (balls[4].weight - balls[i].weight)};
  }
  return rows;
}

Rows<DoublePair> rows_in_pairs(const std::array<WeightedVec, 5>& balls) {
  Rows<DoublePair> rows;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 p = balls[i].position, t = balls[4].position;
    const DoublePair x = exact_sum(p.x, -t.x), y = exact_sum(p.y, -t.y), z = exact_sum(p.z, -t.z);
    rows[i] = {x, y, z, (x * x + y * y) + (z * z + exact_sum(balls[4].weight, -balls[i].weight))};
  }
  return rows;
}

/// The largest that each column has, without any cancellation.
struct Magnitudes {
  double x = 0.0, y = 0.0, z = 0.0, power = 0.0;
};

Magnitudes magnitudes_of(const std::array<WeightedVec, 5>& balls, const Rows<double>& rows) {
  Magnitudes largest;
  for (std::size_t i = 0; i < 4; ++i) {
    const Row<double>& row = rows[i];
    largest.x = std::max(largest.x, std::abs(row.x));
    largest.y = std::max(largest.y, std::abs(row.y));
    largest.z = std::max(largest.z, std::abs(row.z));
    largest.power = std::max(largest.power, row.x * row.x + row.y * row.y + row.z * row.z +
                                                std::abs(balls[4].weight - balls[i].weight));
  }
  return largest;
}

/// Nothing overflows, and what underflows is far below the bounds of the error.
bool is_in_range(const Magnitudes& largest) {
  constexpr double kLeast = 0x1p-100, kMost = 0x1p100;
  return std::min({largest.x, largest.y, largest.z}) > kLeast &&
         std::max({largest.x, largest.y, largest.z}) < kMost && largest.power > kLeast * kLeast &&
         largest.power < kMost * kMost;
}

int sign_beyond(double value, double error) { return value > error ? 1 : value < -error ? -1 : 0; }

}  // namespace

int certain_power_sign(const std::array<WeightedVec, 5>& balls) {
  // The determinant is a sum of 24 terms, each at most the product of the columns' magnitudes. The
  // way to a term has at most 18 roundings of 2^-53 in doubles; in pairs of doubles, at most 13 of
  // 8 2^-106. The factors below are those numbers, rounded up to powers of two.
  constexpr double kErrorOfDoubles = 512.0 * 0x1p-53;
  constexpr double kErrorOfPairs = 4096.0 * 0x1p-106;
  const Rows<double> rows = rows_in_doubles(balls);
  const Magnitudes largest = magnitudes_of(balls, rows);
  if (!is_in_range(largest)) return 0;
  const double product = largest.x * largest.y * largest.z * largest.power;
  const int sign = sign_beyond(-determinant(rows), kErrorOfDoubles * product);
  if (sign != 0) return sign;
  return sign_beyond(-determinant(rows_in_pairs(balls)).high, kErrorOfPairs * product);
}

}  // namespace orbweave::voronoi
