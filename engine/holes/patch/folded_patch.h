// Whether a patch folds back over the sheet that it is to continue.
#pragma once

#include "engine/holes/problem/hole.h"

namespace orbweave {

/// True where more than a tenth of the patch's area faces away from the sheet: more than 120
/// degrees lie between the normal of such a triangle and the mean of the sheet's normals at its
/// corners on the rim. Triangles of new vertices alone do not count as such. Patches that fold come
/// of rims that zigzag between two layers, as those of foliage.
bool is_folded(const HoleProblem& problem, const HolePatch& patch);

}  // namespace orbweave
