// From raw scans to oriented points: cleaning, normals, orientation. Each pass works on chunks with
// their halo and leaves its points in the store, in the order of the raw points; the last are
// streamed into a partition of their own, as scans with normals are from their files.
#pragma once

#include "engine/pipeline/points/cut_stage.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Throws Error (usage) where normals are to be estimated and face a viewpoint that is not given.
void check_viewpoint(const ResolvedJob& job);
/// The same, once the points are counted, and (bad input) where normals are to face the scanner
/// and it is not known where it stood.
void check_side(const ResolvedJob& job, std::uint64_t points_without_view);
/// Throws Error (usage) where the smoothing flattens everything and its halo holds it all: the unit
/// was mistaken.
void check_smoothing(const Job& job, const CleaningFacts& facts);

/// The stages that bring a job's points into chunks. Resumes from the store where it holds a
/// finished partition under the same key.
CutPoints partition_points(const ResolvedJob& job, StageRunner& runner);

}  // namespace orbweave
