// The interpolant of a patch's heights.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/problem/hole.h"
#include "engine/holes/rbf/rbf.h"

namespace orbweave {

/// Fits heights (z) over plane coordinates (x, y) of sites that lie about `spacing` apart. As much
/// smoothing as the heights' own noise calls for (RbfInterpolant::deviance): none on a clean
/// surface, which is interpolated; some tenths of a spacing on a noisy scan.
/// Above options.max_sites: clean sites by greedy choice of centres to options.tolerance, noisy
/// ones by means.
RbfInterpolant fit_heights(const std::vector<Vec3>& places, double spacing,
                           const PatchOptions& options);

}  // namespace orbweave
