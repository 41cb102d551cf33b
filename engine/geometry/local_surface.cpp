#include "engine/geometry/local_surface.h"

#include <algorithm>
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

std::optional<LocalSurface> plane_of(const SpreadSums& spread, const SymmetricEigen& eigen,
                                     Vec3 side) {
  // All on a line: any plane through it would do.
  if (!(spread.weight > 0.0) || !(eigen.values[1] > kALine * eigen.values[2])) return std::nullopt;
  LocalSurface surface;
  surface.u = eigen.vectors[2];
  surface.v = eigen.vectors[1];
  surface.normal = dot(eigen.vectors[0], side) < 0.0 ? -eigen.vectors[0] : eigen.vectors[0];
  surface.c[0] = dot({spread.center[0], spread.center[1], spread.center[2]}, surface.normal);
  return surface;
}

void bend(LocalSurface& plane, const NearColumns& near) {
  double c[6];
  const double condition =
      surface_kernel().fit_quadric(near, &plane.u.x, &plane.v.x, &plane.normal.x, c);
  if (!(condition > kLeastCondition) || !(std::abs(c[0]) <= kFarthestFoot)) return;
  std::copy(std::begin(c), std::end(c), plane.c.begin());
  plane.is_quadratic = true;
}

}  // namespace

void NearPoints::reserve(std::size_t capacity) {
  if (capacity <= capacity_ && !values_.empty()) return;
  capacity_ = capacity;
  constexpr std::size_t kPadding = 4;
  const std::size_t room = capacity + kPadding;
  values_.assign(8 * room, 0.0);
  double* column = values_.data();
  LaneColumns& p = columns.points;
  for (double** start : {&p.x, &p.y, &p.z, &p.normal_x, &p.normal_y, &p.normal_z, &columns.squared,
                         &columns.weight}) {
    *start = column;
    column += room;
  }
}

double LocalSurface::distance_above(Vec3 offset) const {
  const double x = dot(offset, u), y = dot(offset, v);
  const double height = c[0] + x * (c[1] + c[3] * x + c[4] * y) + y * (c[2] + c[5] * y);
  return dot(offset, normal) - height;
}

Vec3 LocalSurface::normal_at(Vec3 offset) const {
  const double x = dot(offset, u), y = dot(offset, v);
  return normalized(normal - (c[1] + 2.0 * c[3] * x + c[4] * y) * u -
                    (c[2] + c[4] * x + 2.0 * c[5] * y) * v);
}

void fit_surfaces(std::span<const SurfaceSamples> samples,
                  std::span<std::optional<LocalSurface>> surfaces) {
  std::array<SpreadSums, kSurfacesAtOnce> spreads{};
  std::array<SymmetricMatrix, kSurfacesAtOnce> matrices{};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].count < kFewestForPlane) continue;
    surface_kernel().spread(*samples[i].near, spreads[i]);
    const auto& p = spreads[i].products;
    if (spreads[i].weight > 0.0) matrices[i] = {p[0], p[1], p[2], p[3], p[4], p[5]};
  }
  const std::array<SymmetricEigen, kSurfacesAtOnce> eigen = eigen_of_four(matrices);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    surfaces[i] = plane_of(spreads[i], eigen[i], samples[i].side);
    if (surfaces[i] && samples[i].count >= kFewestForQuadric) bend(*surfaces[i], *samples[i].near);
  }
}

std::optional<LocalSurface> fit_surface(std::span<const SurfaceSample> samples, Vec3 side) {
  NearPoints points;
  points.reserve(samples.size());
  NearColumns& near = points.columns;
  near.count = static_cast<std::uint32_t>(samples.size());
  for (std::uint32_t i = 0; i < near.count; ++i) {
    near.points.x[i] = samples[i].offset.x;
    near.points.y[i] = samples[i].offset.y;
    near.points.z[i] = samples[i].offset.z;
    near.weight[i] = samples[i].weight;
  }
  std::optional<LocalSurface> surface;
  const SurfaceSamples one{&near, near.count, side};
  fit_surfaces({&one, 1}, {&surface, 1});
  return surface;
}

}  // namespace orbweave
