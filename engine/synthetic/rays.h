// Where a ray first meets a shape: what the virtual scanner sees.
#pragma once

#include <optional>

#include "engine/synthetic/synthetic_cloud.h"

namespace orbweave::synthetic {

struct RayHit {
  double distance = 0.0;  ///< from the ray's origin
  Vec3 normal;            ///< unit length, outward
};

/// First point of the shape on the ray from `origin`, which lies outside `bounding_ball`, along the
/// unit vector `direction`. Exact to rounding. Nothing where the ray misses the shape, where it
/// meets the inner side of an open sheet first, and on a torus or the plate of genus 3 where it
/// meets the surface at more than 84 degrees from the normal; there a ray goes on to the sphere
/// above the torus.
std::optional<RayHit> first_hit(Shape shape, double wall_gap, Vec3 origin, Vec3 direction);

struct Ball {
  Vec3 center;
  double radius = 1.0;
};
/// A ball that holds the shape.
Ball bounding_ball(Shape shape, double wall_gap);

}  // namespace orbweave::synthetic
