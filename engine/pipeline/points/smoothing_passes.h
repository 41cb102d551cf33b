// The passes that move the points of raw scans onto their surface and thin them.
#pragma once

#include "engine/pipeline/points/noise_stage.h"
#include "engine/pipeline/points/raw_passes.h"

namespace orbweave {

/// `oriented`: the normals are.
RawPass smooth_pass(const StageRunner& runner, const LocalCleaning& cleaning, bool oriented,
                    int pass);

RawPass thin_pass(const StageRunner& runner, const LocalCleaning& cleaning, bool oriented);

/// Thinning and the last projection, which only the points that stay need: they are chosen where
/// the projection before left them, and move by the little that is left of the noise.
RawPass thin_and_smooth_pass(const StageRunner& runner, const LocalCleaning& cleaning,
                             bool oriented);

/// Points on different sheets do not replace one another: normals less than 60 degrees apart do.
inline constexpr double kSameSheetCosine = 0.5;

}  // namespace orbweave
