// Small clouds for the tests of partition/; the same bits everywhere.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave::test {

/// Uniform in [0, 1).
inline double unit(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}

/// Points of a bumpy sphere's surface around `center`.
inline std::vector<Vec3> shell(std::size_t count, Vec3 center, double radius, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Vec3> points;
  while (points.size() < count) {
    const Vec3 p{2.0 * unit(random) - 1.0, 2.0 * unit(random) - 1.0, 2.0 * unit(random) - 1.0};
    const double length = norm(p);
    if (length < 0.1 || length > 1.0) continue;
    points.push_back(center + (radius * (0.9 + 0.1 * p.x) / length) * p);
  }
  return points;
}

inline std::vector<Vec3> filled_cube(std::size_t count, Vec3 corner, double side,
                                     std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(corner + side * Vec3{unit(random), unit(random), unit(random)});
  return points;
}

/// Adds normals (single or double) and two attributes, all random.
inline PointCloud dressed(std::vector<Vec3> positions, std::uint64_t seed,
                          ScalarType normal_type = ScalarType::kFloat32) {
  std::mt19937_64 random(seed);
  PointCloud cloud;
  cloud.schema = {true,
                  ScalarType::kFloat64,
                  normal_type,
                  {{"red", ScalarType::kUint8}, {"time", ScalarType::kFloat64}}};
  cloud.positions = std::move(positions);
  const auto component = [&] {
    const double value = 2.0 * unit(random) - 1.0;
    return normal_type == ScalarType::kFloat32 ? static_cast<float>(value) : value;
  };
  for (std::size_t i = 0; i < cloud.positions.size(); ++i) {
    cloud.normals.push_back({component(), component(), component()});
    for (int b = 0; b < 9; ++b) cloud.attributes.push_back(static_cast<std::byte>(random()));
  }
  return cloud;
}

template <class T>
void shuffle(std::vector<T>& values, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[random() % i]);
}

inline PointCloud shuffled(const PointCloud& cloud, std::uint64_t seed) {
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  shuffle(order, seed);
  PointCloud result;
  result.schema = cloud.schema;
  for (const std::size_t i : order) result.append(cloud, i);
  return result;
}

/// Equal to the last bit, the sign of zero included.
inline bool same_bits(const PointCloud& a, const PointCloud& b) {
  const auto equal = [](const auto& x, const auto& y) {
    return x.size() == y.size() &&
           (x.empty() || std::memcmp(x.data(), y.data(), x.size() * sizeof x[0]) == 0);
  };
  return a.schema == b.schema && equal(a.positions, b.positions) && equal(a.normals, b.normals) &&
         equal(a.attributes, b.attributes);
}

}  // namespace orbweave::test
