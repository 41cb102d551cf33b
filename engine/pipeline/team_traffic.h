// The bytes that all processes of a job moved, and their calls of the counter.
#pragma once

#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Adds the bytes and the calls of the other processes to the stages that the root measured. Every
/// process calls it at the end of the job.
void gather_traffic(StageRunner& runner);

}  // namespace orbweave
