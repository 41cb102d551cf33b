#include "engine/cleaning/projection.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "engine/cleaning/neighbor_grid.h"

namespace orbweave {
namespace {

/// exp(-4 t), t the squared distance in radii, but zero at the radius and of the same bits on every
/// machine.
double bell(double t) {
  const double square = (1.0 - t) * (1.0 - t);
  return square * square;
}

/// A quadratic surface has six numbers; it needs clearly more neighbours than that.
constexpr double kFewestForPlane = 3;
constexpr double kFewestForQuadric = 12;

struct Sample {
  Vec3 offset;  ///< from the point projected, in radii
  double weight = 0.0;
};

struct Foot {
  Vec3 offset;  ///< of the foot on the local surface, in radii
  Vec3 normal;
};

Eigen::Vector3d eigen(Vec3 v) { return {v.x, v.y, v.z}; }
Vec3 vec3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

/// Axes of the samples' weighted plane: two in it and its normal.
struct Plane {
  Vec3 center;
  Vec3 u, v, normal;
};

std::optional<Plane> plane_of(const std::vector<Sample>& samples, Vec3 side) {
  double weight = 0.0;
  Vec3 center;
  for (const Sample& sample : samples) {
    weight += sample.weight;
    center = center + sample.weight * sample.offset;
  }
  if (!(weight > 0.0)) return std::nullopt;
  center = center / weight;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Sample& sample : samples) {
    const Eigen::Vector3d d = eigen(sample.offset - center);
    covariance += sample.weight * d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const auto& values = solver.eigenvalues();
  // All on a line: any plane through it would do.
  if (!(values[1] > 1e-6 * values[2])) return std::nullopt;
  Plane plane{center, vec3(solver.eigenvectors().col(2)), vec3(solver.eigenvectors().col(1)),
              vec3(solver.eigenvectors().col(0))};
  if (dot(plane.normal, side) < 0.0) plane.normal = -plane.normal;
  return plane;
}

Foot foot_on_plane(const Plane& plane) {
  return {dot(plane.center, plane.normal) * plane.normal, plane.normal};
}

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Height over the plane at the point and its gradient there: the first three coefficients of the
/// weighted quadratic height field.
std::optional<Foot> foot_on_quadric(const Plane& plane, const std::vector<Sample>& samples) {
  Matrix6 normal_matrix = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  for (const Sample& sample : samples) {
    const double x = dot(sample.offset, plane.u), y = dot(sample.offset, plane.v);
    Vector6 row;
    row << 1.0, x, y, x * x, x * y, y * y;
    normal_matrix.noalias() += sample.weight * row * row.transpose();
    right += sample.weight * dot(sample.offset, plane.normal) * row;
  }
  const Eigen::LDLT<Matrix6> factors(normal_matrix);
  if (factors.info() != Eigen::Success || !(factors.rcond() > 1e-7)) return std::nullopt;
  const Vector6 c = factors.solve(right);
  return Foot{c[0] * plane.normal, normalized(plane.normal - c[1] * plane.u - c[2] * plane.v)};
}

/// One cell's candidates and the samples around one of its points.
class Projector {
 public:
  Projector(std::span<const Vec3> positions, std::span<const Vec3> normals,
            const ProjectionOptions& options)
      : positions_(positions), normals_(normals), options_(options) {}

  std::optional<Foot> project(std::uint32_t point, const std::vector<std::uint32_t>& candidates,
                              std::vector<Sample>& samples) const {
    collect(point, candidates, samples);
    if (static_cast<double>(samples.size()) <= kFewestForPlane) return std::nullopt;
    const auto plane = plane_of(samples, normals_[point]);
    if (!plane) return std::nullopt;
    std::optional<Foot> foot;
    if (static_cast<double>(samples.size()) >= kFewestForQuadric)
      foot = foot_on_quadric(*plane, samples);
    return foot ? foot : foot_on_plane(*plane);
  }

 private:
  void collect(std::uint32_t point, const std::vector<std::uint32_t>& candidates,
               std::vector<Sample>& samples) const {
    samples.clear();
    const double scale = 1.0 / options_.radius;
    for (const std::uint32_t other : candidates) {
      const Vec3 offset = scale * (positions_[other] - positions_[point]);
      const double squared = squared_norm(offset);
      if (squared > 1.0) continue;
      const double agreement = dot(normals_[other], normals_[point]);
      if (options_.oriented && agreement <= 0.0) continue;
      samples.push_back({offset, agreement * agreement * bell(squared)});
    }
  }

  std::span<const Vec3> positions_, normals_;
  ProjectionOptions options_;
};

}  // namespace

ProjectedPoints project_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::uint32_t begin, std::uint32_t end,
                               const ProjectionOptions& options) {
  ProjectedPoints result;
  result.positions.assign(positions.begin() + begin, positions.begin() + end);
  result.normals.assign(normals.begin() + begin, normals.begin() + end);
  result.moved.assign(end - begin, 0);
  const NeighborGrid grid(positions, options.radius);
  const Projector projector(positions, normals, options);
  tbb::parallel_for(std::uint32_t{0}, grid.cells(), [&](std::uint32_t cell) {
    const auto members = grid.members(cell);
    const auto first = std::lower_bound(members.begin(), members.end(), begin);
    const auto last = std::lower_bound(first, members.end(), end);
    if (first == last) return;
    std::vector<std::uint32_t> cells, candidates;
    std::vector<Sample> samples;
    grid.gather(cell, cells, candidates);
    for (auto it = first; it != last; ++it) {
      if (normals[*it] == Vec3{}) continue;
      const auto foot = projector.project(*it, candidates, samples);
      if (!foot) continue;
      result.positions[*it - begin] = positions[*it] + options.radius * foot->offset;
      result.normals[*it - begin] = foot->normal;
      result.moved[*it - begin] = 1;
    }
  });
  return result;
}

}  // namespace orbweave
