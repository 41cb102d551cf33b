// Where rays meet the things of a scene.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/synthetic/rays.h"
#include "engine/synthetic/scene.h"
#include "io/box.h"

namespace orbweave::synthetic {

/// A bounding volume hierarchy over the triangles of a scene that stop rays.
class SceneRays {
 public:
  explicit SceneRays(std::span<const SceneTriangle> triangles);
  /// The first triangle on the ray from `origin` along the unit vector `direction`, from either
  /// side; of the triangles that share an edge any of them. Empty where the ray meets nothing.
  /// Möller, Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
  std::optional<RayHit> first_hit(Vec3 origin, Vec3 direction) const;

 private:
  struct Corners {
    Vec3 a, to_b, to_c, normal;
  };
  /// A leaf has `count` triangles from `first` on; an inner node the children `first` and
  /// `first + 1`.
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;
  };
  void split(std::size_t node);

  std::vector<Corners> triangles_;
  std::vector<Node> nodes_;
};

/// The side of an upright cylinder, from `foot` up.
std::optional<RayHit> cylinder_hit(Vec3 foot, double radius, double height, Vec3 origin,
                                   Vec3 direction);

/// Where a ray enters and leaves a ball that its origin lies outside of.
struct RayChord {
  double enter = 0.0, leave = 0.0;  ///< distances from the origin
};
std::optional<RayChord> ball_chord(Vec3 center, double radius, Vec3 origin, Vec3 direction);

}  // namespace orbweave::synthetic
