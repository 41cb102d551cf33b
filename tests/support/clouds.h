// Small clouds that tests make themselves: bit-portable (raw mt19937_64 output, own
// distributions), positions in canonical order, normals exact but for noise.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave::test {

/// Uniform in [0, 1), the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  /// In [-1, 1), bell-shaped: the mean of three.
  double bell() { return (uniform() + uniform() + uniform()) / 1.5 - 1.0; }
  Vec3 direction();
  std::uint64_t below(std::uint64_t n) { return bits_() % n; }

 private:
  std::mt19937_64 bits_;
};

struct NamedCloud {
  std::string name;
  PointCloud cloud;
  double ball_radius = 0.0;
};

/// The same points without their normals.
NamedCloud without_normals(NamedCloud named);
/// A torus in hexagonal rows; noise in units of the spacing, along random directions.
NamedCloud noisy_torus(std::size_t points, double noise, std::uint64_t seed);
/// Points on a sphere, at random: uneven on purpose.
NamedCloud random_sphere(std::size_t points, std::uint64_t seed);
/// The unit sphere, and about (1, 0, 0) a crowd of that width: on the sphere, or on all sides of
/// it.
NamedCloud sphere_with_crowd(std::size_t points, std::size_t crowd, double width, bool on_sphere,
                             std::uint64_t seed);
/// A square grid, full of co-circular points; two sheets when `gap` is not 0.
NamedCloud grid_sheet(int side, double gap);
/// A wavy sheet over a square whose points lie on lines, `ratio` times as far apart as the points
/// on them, as a scanner of profiles leaves them.
NamedCloud sheet_of_lines(double ratio, std::size_t points);
/// Points anywhere in a ball with any normals: nothing like a surface.
NamedCloud random_ball(std::size_t points, std::uint64_t seed);
/// All of these, small enough for an oracle that tries every triple.
std::vector<NamedCloud> clouds_for_oracle();

/// Sorts canonically (and merges duplicates), as the pipeline does.
void put_in_order(PointCloud& cloud);

}  // namespace orbweave::test
