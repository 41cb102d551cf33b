#include "engine/holes/plane/hole_frame.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/geometry/plane_axes.h"
#include "engine/holes/patch/patch_mesh.h"

namespace orbweave {
namespace {

HoleFrame frame_about(Vec3 axis) {
  const PlaneAxes axes = plane_axes(axis);
  return {axes.u, axes.v, axis};
}

Vec3 area_vector(const Rim& rim) {
  Vec3 sum;
  const std::size_t n = rim.corners.size();
  for (std::size_t i = 0; i < n; ++i) sum = sum + cross(rim.corners[i], rim.corners[(i + 1) % n]);
  return 0.5 * sum;
}

Vec3 mean_face_normal(const Rim& rim) {
  Vec3 sum;
  const std::size_t n = rim.corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    sum = sum + norm(rim.corners[(i + 1) % n] - rim.corners[i]) * rim.face_normals[i];
  }
  return normalized(sum);
}

double least_upright(const Rim& rim, Vec3 axis) {
  double least = 1.0;
  for (const Vec3 normal : rim.face_normals) {
    if (normal != Vec3{}) least = std::min(least, dot(normal, axis));
  }
  return least;
}

// The direction that makes the least cosine with a face largest: the centre of the smallest cap of
// the sphere around all faces' normals, to about a degree. After n steps the error is at most the
// cap's radius by the root of n.
// Badoiu, Clarkson: Smaller Core-Sets for Balls, SODA 2003.
Vec3 most_upright_axis(const Rim& rim, Vec3 start) {
  constexpr int kSteps = 200;
  constexpr double kDegree = std::numbers::pi / 180.0;
  std::vector<Vec3> normals = rim.face_normals;
  std::erase(normals, Vec3{});
  Vec3 center = start;
  for (int step = 1; step <= kSteps; ++step) {
    const Vec3* furthest = &start;
    double least = 2.0;
    for (const Vec3& normal : normals) {
      const double cosine = dot(normal, center);
      furthest = cosine < least ? &normal : furthest;
      least = cosine < least ? cosine : least;
    }
    const Vec3 way = *furthest - center;
    if (squared_norm(way) < kDegree * kDegree * static_cast<double>(step)) break;
    center = center + way / static_cast<double>(step + 1);
  }
  return normalized(center);
}

// The direction of least extent of the sheet near the rim (principal component analysis), up.
Vec3 principal_axis(const HoleProblem& problem, const Rim& rim, Vec3 up) {
  constexpr double kNear = 1.5;  // radii from the centre
  std::vector<Vec3> near;
  Vec3 sum;
  for (std::size_t i = 0; i < problem.positions.size(); ++i) {
    const Vec3 x = problem.positions[i] - rim.center;
    if (norm(x) > kNear * rim.radius || dot(problem.normals[i], up) < kLeastUpright) continue;
    near.push_back(x);
    sum = sum + x;
  }
  if (near.size() < 3) return up;
  const Vec3 mean = sum / static_cast<double>(near.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vec3 x : near) {
    const Vec3 d = (x - mean) / rim.radius;
    const Eigen::Vector3d e(d.x, d.y, d.z);
    covariance += e * e.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance);
  const Eigen::Vector3d least = solver.eigenvectors().col(0);
  const Vec3 axis = normalized(Vec3{least[0], least[1], least[2]});
  return dot(axis, up) < 0.0 ? -axis : axis;
}

bool is_simple_in(const HoleFrame& frame, const Rim& rim) {
  std::vector<Vec3> places;
  for (const Vec3 corner : rim.corners) places.push_back(frame.to_frame(corner));
  return is_weakly_simple(snap_to_grid(places, rim.radius));
}

}  // namespace

std::vector<PlanePoint> snap_to_grid(std::span<const Vec3> places, double radius) {
  const double scale = static_cast<double>(kPlaneExtent) / (1.001 * radius);
  std::vector<PlanePoint> points;
  points.reserve(places.size());
  for (const Vec3 place : places) {
    points.push_back({std::llround(place.x * scale), std::llround(place.y * scale)});
  }
  return points;
}

FrameChoice choose_frame(const HoleProblem& problem, const Rim& rim) {
  const Vec3 area = normalized(area_vector(rim));
  const Vec3 faces = mean_face_normal(rim);
  const Vec3 between = normalized(area + faces);
  if (between == Vec3{}) return {std::nullopt, "the loop has no side"};
  const Vec3 best = most_upright_axis(rim, between);
  if (best == Vec3{} || least_upright(rim, best) < kLeastUpright)
    return {std::nullopt, "the sheet along the rim is too steep for a height field"};
  if (const HoleFrame frame = frame_about(best); is_simple_in(frame, rim)) return {frame, {}};
  // The others are less upright, but the loop may be simple along them.
  struct Candidate {
    double upright = 0.0;
    Vec3 axis;
  };
  std::vector<Candidate> candidates;
  for (const Vec3 axis : {between, area, faces, principal_axis(problem, rim, between)})
    candidates.push_back({least_upright(rim, axis), axis});
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.upright > b.upright; });
  for (const Candidate& candidate : candidates) {
    if (candidate.upright < kLeastUpright || candidate.axis == Vec3{}) break;
    const HoleFrame frame = frame_about(candidate.axis);
    if (is_simple_in(frame, rim)) return {frame, {}};
  }
  return {std::nullopt, "the loop overlaps itself seen along the hole's normal"};
}

}  // namespace orbweave
