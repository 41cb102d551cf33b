// Whether a surface ends at a hole in a crease, so that its smooth continuation would be wrong.
#pragma once

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// True where the rim lies in a plane, the sheet meets that plane steeply all along it, and the
/// sheet does not bend towards the hole as it comes near: the reveal of a window, the wall of a
/// box, the foot of a statue. A smooth patch would bulge out of such a rim like a balloon; a flat
/// one assumes least. False for the cap of a sphere, which bends, and for loops of a few edges.
bool ends_in_crease(const HoleProblem& problem);

}  // namespace orbweave
