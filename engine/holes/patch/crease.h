// Whether a surface ends at a hole in a crease, so that its smooth continuation would be wrong.
#pragma once

#include <optional>

#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// A rim measured by its own plane, which is perpendicular to its area vector.
struct RimShape {
  /// Root of the mean squared distance of the corners from the plane, in mean lengths of the edges.
  double roughness = 0.0;
  /// The sheet half a width behind the rim is parallel to the plane at most places: the rim is that
  /// of an opening in a wall, and not the end of a tube or the foot of a statue.
  bool is_in_wall = false;
};
RimShape rim_shape(const HoleProblem& problem);

/// A plane behind the sheet around a hole: dot(x, axis) = depth, x relative to the rim's centre.
struct RecessedPlane {
  Vec3 axis;  ///< unit, on the side of the sheet's normals
  double depth = 0.0;
  double wall = 0.0;  ///< where the sheet lies, by the same measure
};

/// Where the rim is the lip of a recess, of which the scanner saw some sides down to the ground and
/// others not: the plane that is parallel to the sheet and goes through the deepest parts of the
/// rim. A window's pane lies there. Empty where the rim is no such lip, or where it lies in one
/// plane as it is. The plane says something where FlatCall::recess has it, and nothing of other
/// rims.
std::optional<RecessedPlane> recessed_plane(const HoleProblem& problem);

/// What calls for a flat patch rather than a smooth one.
struct FlatCall {
  /// The rim lies in a plane that the sheet meets steeply, without bending towards the hole: the
  /// reveal of a window, the wall of a box, the foot of a statue. A smooth patch would bulge out of
  /// such a rim like a balloon; a flat one assumes least.
  bool is_crease = false;
  /// Where the rim is the lip of a recess: the recess's ground. Corners lie on two levels there, or
  /// the surface ends in a crease.
  std::optional<RecessedPlane> recess;
  bool any() const { return is_crease || recess; }
};
/// `rim`: of the problem.
FlatCall call_for_flat_patch(const HoleProblem& problem, const Rim& rim);

/// As RimShape::roughness, from the ground of a recess or the wall, whichever of the two is closer
/// to a corner.
double roughness_of_recess(const HoleProblem& problem, const RecessedPlane& plane);

}  // namespace orbweave
