// Flat pieces that scenes are put together from. Metres, z up.
#pragma once

#include <span>

#include "engine/synthetic/scene.h"

namespace orbweave::synthetic {

/// A parallelepiped: a corner and the three edges that leave it, a right-handed system.
struct Block {
  Vec3 corner, a, b, c;
};

/// Faces of a block that a scene leaves out because they touch another surface.
enum BlockFace : unsigned {
  kFaceAtA = 1,
  kFaceBeyondA = 2,
  kFaceAtB = 4,
  kFaceBeyondB = 8,
  kFaceAtC = 16,
  kFaceBeyondC = 32
};

/// An opening in a wall, in metres along the wall from its origin and above the wall's foot.
struct Opening {
  double left = 0.0, bottom = 0.0, width = 0.0, height = 0.0;
  double depth = 0.0;    ///< of the reveal; 0: none, and no pane
  bool has_pane = true;  ///< glass at the far end of the reveal; false: a doorway
};

/// An upright wall, seen from the side of `normal`. `origin`: the foot of its left edge as seen
/// from there, from which `length` runs to the right.
struct Wall {
  Vec3 origin, normal;  ///< the normal is horizontal and of unit length
  double length = 0.0, height = 0.0;
};

class SceneBuilder {
 public:
  /// Counterclockwise as seen from the air.
  void add_triangle(Vec3 a, Vec3 b, Vec3 c, SceneRole role = SceneRole::kSurface);
  void add_quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d, SceneRole role = SceneRole::kSurface);
  /// Faces outward. `left_out`: a sum of faces.
  void add_block(const Block& block, unsigned left_out = 0, SceneRole role = SceneRole::kSurface);
  void add_box(Vec3 low, Vec3 high, unsigned left_out = 0);
  /// A wall with rectangular openings, their reveals and panes.
  void add_wall(const Wall& wall, std::span<const Opening> openings);
  /// The side of an upright prism of `sides` sides around a vertical axis, from `foot` up to
  /// height_at(x, y), which a ceiling has there.
  template <class HeightAt>
  void add_pillar(Vec3 foot, double radius, int sides, const HeightAt& height_at, SceneRole role) {
    for (int k = 0; k < sides; ++k) {
      const Vec3 a = on_circle(foot, radius, k, sides), b = on_circle(foot, radius, k + 1, sides);
      add_quad(a, b, {b.x, b.y, height_at(b)}, {a.x, a.y, height_at(a)}, role);
    }
  }
  /// A ball, seen from outside.
  void add_ball(Vec3 center, double radius, int meridians);

  Scene scene;

 private:
  static Vec3 on_circle(Vec3 center, double radius, int k, int sides);
  void add_opening(const Wall& wall, Vec3 along, const Opening& opening);

  std::uint8_t panes_ = 0;
};

}  // namespace orbweave::synthetic
