#include "tests/support/clouds.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "partition/canonical_order.h"

namespace orbweave::test {
namespace {

PointCloud oriented() {
  PointCloud cloud;
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = ScalarType::kFloat64;
  return cloud;
}

void add(PointCloud& cloud, Vec3 p, Vec3 n) {
  cloud.positions.push_back(p);
  cloud.normals.push_back(n);
}

}  // namespace

Vec3 Random::direction() {
  for (;;) {
    const Vec3 v{2.0 * uniform() - 1.0, 2.0 * uniform() - 1.0, 2.0 * uniform() - 1.0};
    const double squared = squared_norm(v);
    if (squared > 0.01 && squared <= 1.0) return v / std::sqrt(squared);
  }
}

void put_in_order(PointCloud& cloud) { sort_canonically(cloud, root_cube(cloud.bounds())); }

NamedCloud without_normals(NamedCloud named) {
  named.cloud.normals.clear();
  named.cloud.schema.has_normals = false;
  return named;
}

NamedCloud noisy_torus(std::size_t points, double noise, std::uint64_t seed) {
  constexpr double kPi = std::numbers::pi, kMajor = 1.0, kMinor = 0.4;
  const double spacing = std::sqrt(4.0 * kPi * kPi * kMajor * kMinor / static_cast<double>(points));
  Random random(seed);
  NamedCloud result{"torus, noise " + std::to_string(noise), oriented(), 1.3 * spacing};
  const int rows = static_cast<int>(2.0 * kPi * kMinor / (spacing * 0.866) + 0.5);
  for (int i = 0; i < rows; ++i) {
    const double v = 2.0 * kPi * i / rows;
    const double ring = kMajor + kMinor * std::cos(v);
    const int columns = static_cast<int>(2.0 * kPi * ring / (spacing / 0.866) + 0.5);
    for (int k = 0; k < columns; ++k) {
      const double u = 2.0 * kPi * (k + 0.5 * (i % 2)) / columns;
      const Vec3 n{std::cos(v) * std::cos(u), std::cos(v) * std::sin(u), std::sin(v)};
      const Vec3 p{ring * std::cos(u), ring * std::sin(u), kMinor * std::sin(v)};
      add(result.cloud, p + noise * spacing * Vec3{random.bell(), random.bell(), random.bell()}, n);
    }
  }
  put_in_order(result.cloud);
  return result;
}

NamedCloud random_sphere(std::size_t points, std::uint64_t seed) {
  Random random(seed);
  NamedCloud result{"random sphere", oriented(), 4.0 / std::sqrt(static_cast<double>(points))};
  for (std::size_t i = 0; i < points; ++i) {
    const Vec3 n = random.direction();
    add(result.cloud, n, n);
  }
  put_in_order(result.cloud);
  return result;
}

NamedCloud sphere_with_crowd(std::size_t points, std::size_t crowd, double width, bool on_sphere,
                             std::uint64_t seed) {
  Random random(seed);
  NamedCloud result = random_sphere(points, seed);
  result.name = on_sphere ? "sphere with a dense patch" : "sphere with a dense spot";
  for (std::size_t i = 0; i < crowd; ++i) {
    const Vec3 p = {1.0 + (on_sphere ? 0.0 : width * random.bell()), width * random.bell(),
                    width * random.bell()};
    const Vec3 n = normalized(p);
    add(result.cloud, on_sphere ? n : p, n);
  }
  put_in_order(result.cloud);
  return result;
}

NamedCloud grid_sheet(int side, double gap) {
  NamedCloud result{gap > 0.0 ? "double grid" : "grid", oriented(), 1.3};
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const Vec3 p{static_cast<double>(x), static_cast<double>(y), 0.0};
      add(result.cloud, p, {0, 0, 1});
      if (gap > 0.0) add(result.cloud, p - Vec3{0, 0, gap}, {0, 0, -1});
    }
  }
  put_in_order(result.cloud);
  return result;
}

NamedCloud sheet_of_lines(double ratio, std::size_t points) {
  NamedCloud named{"sheet of lines", {}, 0.0};
  named.cloud.schema.has_normals = true;
  const double step = 1.0 / std::sqrt(ratio * static_cast<double>(points));
  named.ball_radius = 0.6 * ratio * step;
  Random random(7);
  for (double line = 0.0; line <= 1.0; line += ratio * step) {
    const double first = (random.uniform() - 0.5) * step;
    for (double place = first; place <= 1.0; place += step) {
      const double x = place + 0.1 * random.bell() * step;
      const double y = line + 0.1 * random.bell() * step;
      const double turn = 9.0 * x + 4.0 * y, slope = 0.03 * std::cos(turn);
      named.cloud.positions.push_back({x, y, 0.03 * std::sin(turn)});
      named.cloud.normals.push_back(normalized({-9.0 * slope, -4.0 * slope, 1.0}));
    }
  }
  put_in_order(named.cloud);
  return named;
}

NamedCloud random_ball(std::size_t points, std::uint64_t seed) {
  Random random(seed);
  NamedCloud result{"random ball", oriented(), 0.5};
  for (std::size_t i = 0; i < points; ++i) {
    // Arguments are evaluated in an order of the compiler's: the cloud is the same with any.
    const double distance = std::cbrt(random.uniform());
    const Vec3 place = distance * random.direction();
    add(result.cloud, place, random.direction());
  }
  put_in_order(result.cloud);
  return result;
}

std::vector<NamedCloud> clouds_for_oracle() {
  std::vector<NamedCloud> clouds;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    clouds.push_back(noisy_torus(120, 0.0, seed));
    clouds.push_back(noisy_torus(120, 0.3, seed));
    clouds.push_back(noisy_torus(120, 0.8, seed));
    clouds.push_back(random_sphere(100, seed));
    clouds.push_back(random_ball(60, seed));
  }
  clouds.push_back(grid_sheet(9, 0.0));
  clouds.push_back(grid_sheet(7, 0.5));
  clouds.push_back(grid_sheet(7, 3.0));
  return clouds;
}

}  // namespace orbweave::test
