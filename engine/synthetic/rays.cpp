// Planes, the cube and the sphere are met in closed form. Rays to the tori and the plate step by a
// lower bound of the distance (sphere tracing: Hart, Sphere tracing: a geometric method for the
// antialiased ray tracing of implicit surfaces, 1996, section 2), and Newton's method ends them.
#include "engine/synthetic/rays.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/synthetic/plate.h"
#include "engine/synthetic/surfaces.h"

namespace orbweave::synthetic {
namespace {

using Hit = std::optional<RayHit>;

Hit sphere_hit(Vec3 origin, Vec3 direction) {
  const double along = -dot(origin, direction);
  const Vec3 nearest = origin + along * direction;
  const double square = 1.0 - squared_norm(nearest);
  if (!(square >= 0.0)) return std::nullopt;
  const double distance = along - std::sqrt(square);
  return RayHit{distance, normalized(origin + distance * direction)};
}

/// The unit square at height z, seen from the side of its normal, which is up or down.
Hit square_hit(Vec3 origin, Vec3 direction, double z, double up) {
  if (!(up * direction.z < 0.0)) return std::nullopt;
  const double distance = (z - origin.z) / direction.z;
  const Vec3 p = origin + distance * direction;
  if (!(p.x >= 0.0 && p.x <= 1.0 && p.y >= 0.0 && p.y <= 1.0)) return std::nullopt;
  return RayHit{distance, {0.0, 0.0, up}};
}

Hit cube_hit(Vec3 origin, Vec3 direction) {
  double enter = -std::numeric_limits<double>::infinity();
  double leave = std::numeric_limits<double>::infinity();
  Vec3 normal;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) {
      if (!(origin[axis] >= 0.0 && origin[axis] <= 1.0)) return std::nullopt;
      continue;
    }
    const double side = direction[axis] > 0.0 ? 0.0 : 1.0;
    const double near = (side - origin[axis]) / direction[axis];
    leave = std::min(leave, (1.0 - side - origin[axis]) / direction[axis]);
    if (near <= enter) continue;
    enter = near;
    normal = {};
    normal[axis] = 2.0 * side - 1.0;
  }
  if (!(enter <= leave)) return std::nullopt;
  return RayHit{enter, normal};
}

double distance_to_torus(Vec3 p, double tube_radius) {
  const double from_axis = std::sqrt(p.x * p.x + p.y * p.y) - kMajorRadius;
  return std::sqrt(from_axis * from_axis + p.z * p.z) - tube_radius;
}

/// No point of the surface is nearer than that to p, which is outside of it.
double free_distance(Shape shape, Vec3 p) {
  if (shape == Shape::kTorus) return distance_to_torus(p, kTubeRadius);
  if (shape == Shape::kGenusThree) return plate_field(p).value;
  // Far from the bumps: the torus that encloses them. Among them the field's gradient is below
  // 1.6: away from the centre line 1, along the ring at most 0.36 / 0.35, around the tube at most
  // 0.16 / 0.31 (slopes of the bumps over the shortest distances from axis and centre line).
  const double to_enclosing = distance_to_torus(p, kLargestTube);
  return to_enclosing > 0.01 ? to_enclosing : bumpy_torus_field(p).value / 1.6;
}

TubeField tube_field(Shape shape, Vec3 p) {
  if (shape == Shape::kGenusThree) return plate_field(p);
  return shape == Shape::kTorus ? torus_field(p) : bumpy_torus_field(p);
}

/// The end of a ray that is close to the surface and not parallel to it.
Hit newton_hit(Shape shape, Vec3 origin, Vec3 direction, double distance) {
  TubeField field = tube_field(shape, origin + distance * direction);
  for (int step = 0; step < 6; ++step) {
    const double slope = dot(field.gradient, direction);
    if (!(slope < -0.1 * norm(field.gradient))) return std::nullopt;
    distance -= field.value / slope;
    field = tube_field(shape, origin + distance * direction);
  }
  return RayHit{distance, normalized(field.gradient)};
}

Hit traced_hit(Shape shape, Vec3 origin, Vec3 direction) {
  constexpr double kClose = 1e-3;  // Newton's first step cannot jump over the tube from there
  constexpr double kTouching = 1e-7;
  constexpr int kMostSteps = 2000;
  const double end = 2.0 * norm(origin);
  double distance = 0.0;
  for (int step = 0; step < kMostSteps && distance < end; ++step) {
    const double free = free_distance(shape, origin + distance * direction);
    if (free < kClose)
      if (const Hit hit = newton_hit(shape, origin, direction, distance)) return hit;
    if (free < kTouching) return std::nullopt;
    distance += free;
  }
  return std::nullopt;
}

Hit upper_sphere_hit(Vec3 origin, Vec3 direction) {
  Hit hit = sphere_hit((origin - kUpperCenter) / kUpperRadius, direction);
  if (hit) hit->distance *= kUpperRadius;
  return hit;
}

Hit nearer(Hit a, Hit b) {
  if (!a || !b) return a ? a : b;
  return a->distance <= b->distance ? a : b;
}

}  // namespace

std::optional<RayHit> first_hit(Shape shape, double wall_gap, Vec3 origin, Vec3 direction) {
  switch (shape) {
    case Shape::kSphere:
      return sphere_hit(origin, direction);
    case Shape::kTorus:
    case Shape::kBumpyTorus:
    case Shape::kGenusThree:
      return traced_hit(shape, origin, direction);
    case Shape::kPlane:
      return square_hit(origin, direction, 0.0, 1.0);
    case Shape::kDoubleWall:
      // From above the lower wall shows its inner side at most, and the other way round.
      return direction.z < 0.0 ? square_hit(origin, direction, wall_gap, 1.0)
                               : square_hit(origin, direction, 0.0, -1.0);
    case Shape::kCube:
      return cube_hit(origin, direction);
    case Shape::kTwoComponents:
      return nearer(upper_sphere_hit(origin, direction),
                    traced_hit(Shape::kTorus, origin, direction));
  }
  return std::nullopt;
}

Ball bounding_ball(Shape shape, double wall_gap) {
  const double half_diagonal = std::sqrt(0.5);
  switch (shape) {
    case Shape::kSphere:
      return {{}, 1.0};
    case Shape::kTorus:
      return {{}, kMajorRadius + kTubeRadius};
    case Shape::kBumpyTorus:
      return {{}, kMajorRadius + kLargestTube};
    case Shape::kPlane:
      return {{0.5, 0.5, 0.0}, half_diagonal};
    case Shape::kDoubleWall:
      return {{0.5, 0.5, 0.5 * wall_gap}, std::sqrt(0.5 + 0.25 * wall_gap * wall_gap)};
    case Shape::kCube:
      return {{0.5, 0.5, 0.5}, std::sqrt(0.75)};
    case Shape::kTwoComponents:
      return {{}, kUpperCenter.z + kUpperRadius};
    case Shape::kGenusThree:
      return {{}, kPlateRadius + kPlateHalf};
  }
  return {};
}

}  // namespace orbweave::synthetic
