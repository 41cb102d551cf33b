// What is doubtful about a mesh that was made all the same.
#pragma once

#include "engine/pipeline/run_results.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Warns of a mesh that is full of holes, else of one that lacks more than a fifth of the points
/// for reasons that the job did not ask for: no triangle uses them, or they have no normal. And of
/// a closed surface that shows its inner side although nothing says that it was seen from there.
void warn_of_doubtful_mesh(StageRunner& runner, const RunResults& results);

}  // namespace orbweave
