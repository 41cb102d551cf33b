// From raw scans to oriented points: cleaning, normals, orientation. Each pass works on chunks with
// their halo and leaves its points in the store, in the order of the raw points; the last are
// streamed into a partition of their own, as scans with normals are from their files.
#pragma once

#include "engine/pipeline/points/cut_stage.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// The stages that bring a job's points into chunks. Resumes from the store where it holds a
/// finished partition under the same key.
CutPoints partition_points(const ResolvedJob& job, StageRunner& runner);

}  // namespace orbweave
