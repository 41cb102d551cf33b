#include "engine/synthetic/scanner_pose.h"

#include <cmath>

#include "engine/synthetic/portable_math.h"

namespace orbweave::synthetic {
namespace {

Quaternion normalized(Quaternion q) {
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& part : q) part /= length;
  return q;
}

Vec3 random_direction(std::uint64_t seed, std::uint64_t index) {
  return normalized(portable::gaussian(seed, index));
}

}  // namespace

Quaternion product(const Quaternion& a, const Quaternion& b) {
  const Vec3 u{a[0], a[1], a[2]}, v{b[0], b[1], b[2]};
  const Vec3 w = a[3] * v + b[3] * u + cross(u, v);
  return {w.x, w.y, w.z, a[3] * b[3] - dot(u, v)};
}

Quaternion turn_around_z(double turns) {
  const portable::SineCosine half = portable::sine_cosine(0.5 * turns);
  return {0, 0, half.sine, half.cosine};
}

void PointMoments::add(Vec3 p) {
  points += 1.0;
  sum = sum + p;
  for (int axis = 0; axis < 3; ++axis) products[axis] = products[axis] + p[axis] * p;
}

void PointMoments::add(const PointMoments& other) {
  points += other.points;
  sum = sum + other.sum;
  for (int axis = 0; axis < 3; ++axis) products[axis] = products[axis] + other.products[axis];
}

double PointMoments::leverage(Vec3 axis) const {
  const Vec3 m = mean();
  double square = 0.0, along = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 row = products[k] / points - m[k] * m;
    square += row[k];
    along += axis[k] * dot(row, axis);
  }
  return square * squared_norm(axis) - along;
}

ScannerPose misregistered(const Quaternion& rotation, Vec3 translation, const PointMoments& moments,
                          double displacement, std::uint64_t seed, std::uint64_t index) {
  const double part = displacement * std::sqrt(0.5);
  const Vec3 shift = part * random_direction(seed, 2 * index);
  const Vec3 axis = random_direction(seed, 2 * index + 1);
  const double leverage = moments.points > 0.0 ? moments.leverage(axis) : 0.0;
  const double angle = leverage > 0.0 ? part / std::sqrt(leverage) : 0.0;
  const Vec3 middle = moments.points > 0.0 ? moments.mean() : Vec3{};
  const Vec3 half = 0.5 * angle * axis;
  const RigidMotion turn = motion_of_quaternion({half.x, half.y, half.z, 1.0}, {});
  const Quaternion q = normalized(product({half.x, half.y, half.z, 1.0}, rotation));
  ScannerPose pose;
  pose.translation = middle + shift + turn.direction(translation - middle);
  pose.motion = motion_of_quaternion(q, pose.translation);
  pose.quaternion = {-q[0], -q[1], -q[2], q[3]};
  return pose;
}

}  // namespace orbweave::synthetic
