// Whether a surface ends at a hole in a crease, so that its smooth continuation would be wrong.
#pragma once

#include <optional>

#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// True where the rim lies in a plane, the sheet meets that plane steeply all along it, and the
/// sheet does not bend towards the hole as it comes near: the reveal of a window, the wall of a
/// box, the foot of a statue. A smooth patch would bulge out of such a rim like a balloon; a flat
/// one assumes least. False for the cap of a sphere, which bends, and for loops of a few edges.
/// `rim`: of the problem.
bool ends_in_crease(const HoleProblem& problem, const Rim& rim);

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
/// plane as it is. Precondition: ends_in_crease(), or is_stepped() of what comes of it.
std::optional<RecessedPlane> recessed_plane(const HoleProblem& problem);

/// True where the corners of the rim lie on two levels, the sheet and the ground, with hardly any
/// between, and the ground is shallow for the width of the hole. The scanner saw parts of a
/// recess's ground and none of the sides there: the sheet need not be steep along such a rim.
bool is_stepped(const HoleProblem& problem, const RecessedPlane& plane);

/// Whether the rim is one that a flat patch is tried for first: it ends in a crease, or is the lip
/// of a recess. `rim`: of the problem.
bool calls_for_flat_patch(const HoleProblem& problem, const Rim& rim);

/// As RimShape::roughness, from the ground of a recess or the wall, whichever of the two is closer
/// to a corner.
double roughness_of_recess(const HoleProblem& problem, const RecessedPlane& plane);

}  // namespace orbweave
