// Whether a patch folds back over the sheet that it is to continue.
#pragma once

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The share of a patch's area that faces away from the sheet: more than 120 degrees lie between
/// the normal of such a triangle and the mean of the sheet's normals at its corners on the rim.
/// Triangles of new vertices alone count as unfolded. 0 for a patch without area.
double folded_share(const HoleProblem& problem, const HolePatch& patch);

/// True where more than a tenth of the area is folded. No surface that is seen from one side
/// goes on like that. Such patches come of rims that zigzag between the layers of foliage, and most
/// of their area is wrong, the unfolded part included.
bool is_folded(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
