#include "engine/geometry/local_surface.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "engine/geometry/symmetric_eigen.h"

namespace orbweave {
namespace {

constexpr std::size_t kFewestForPlane = 3;
/// A quadratic surface has six numbers; noise needs clearly more samples than that.
constexpr std::size_t kFewestForQuadric = 12;
/// Variance across over that along, below which samples lie on a line.
constexpr double kALine = 1e-6;
/// Below that, two rows of samples or the like tell no curvature.
constexpr double kLeastCondition = 1e-7;
/// A foot farther off, in radii of the neighbourhood, is extrapolated.
constexpr double kFarthestFoot = 0.5;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

SymmetricMatrix outer(Vec3 a, double weight) {
  const Vec3 b = weight * a;
  return {b.x * a.x, b.x * a.y, b.x * a.z, b.y * a.y, b.y * a.z, b.z * a.z};
}

std::optional<LocalSurface> fit_plane(std::span<const SurfaceSample> samples, Vec3 side) {
  double weight = 0.0;
  Vec3 center;
  for (const SurfaceSample& sample : samples) {
    weight += sample.weight;
    center = center + sample.weight * sample.offset;
  }
  if (!(weight > 0.0)) return std::nullopt;
  center = center / weight;
  SymmetricMatrix covariance;
  for (const SurfaceSample& sample : samples)
    covariance += outer(sample.offset - center, sample.weight);
  const SymmetricEigen eigen = eigen_of(covariance);
  // All on a line: any plane through it would do.
  if (!(eigen.values[1] > kALine * eigen.values[2])) return std::nullopt;
  LocalSurface surface;
  surface.u = eigen.vectors[2];
  surface.v = eigen.vectors[1];
  surface.normal = dot(eigen.vectors[0], side) < 0.0 ? -eigen.vectors[0] : eigen.vectors[0];
  surface.c[0] = dot(center, surface.normal);
  return surface;
}

void bend(LocalSurface& plane, std::span<const SurfaceSample> samples) {
  Matrix6 products = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  for (const SurfaceSample& sample : samples) {
    const double x = dot(sample.offset, plane.u), y = dot(sample.offset, plane.v);
    const double row[6] = {1.0, x, y, x * x, x * y, y * y};
    const double height = sample.weight * dot(sample.offset, plane.normal);
    for (int i = 0; i < 6; ++i) {
      const double weighted = sample.weight * row[i];
      for (int j = 0; j <= i; ++j) products(i, j) += weighted * row[j];
      right[i] += height * row[i];
    }
  }
  const Eigen::LDLT<Matrix6, Eigen::Lower> factors(products);
  if (factors.info() != Eigen::Success || !(factors.rcond() > kLeastCondition)) return;
  const Vector6 c = factors.solve(right);
  if (!(std::abs(c[0]) <= kFarthestFoot)) return;
  for (int i = 0; i < 6; ++i) plane.c[i] = c[i];
  plane.is_quadratic = true;
}

}  // namespace

double LocalSurface::distance_above(Vec3 offset) const {
  const double x = dot(offset, u), y = dot(offset, v);
  const double height = c[0] + x * (c[1] + c[3] * x + c[4] * y) + y * (c[2] + c[5] * y);
  return dot(offset, normal) - height;
}

std::optional<LocalSurface> fit_surface(std::span<const SurfaceSample> samples, Vec3 side) {
  if (samples.size() < kFewestForPlane) return std::nullopt;
  std::optional<LocalSurface> surface = fit_plane(samples, side);
  if (surface && samples.size() >= kFewestForQuadric) bend(*surface, samples);
  return surface;
}

}  // namespace orbweave
