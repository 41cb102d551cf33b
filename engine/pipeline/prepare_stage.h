// From raw scans to oriented points: clean-up, normals, orientation. Each pass works on chunks with
// their halo and leaves its points in the store, in the order of the raw points; the last are
// streamed into a partition of their own, as scans with normals are from their files.
#pragma once

#include "engine/pipeline/partition_stage.h"

namespace orbweave {

/// The job's points, prepared as the job asks for, cut and sorted into kPointsStage (and not yet
/// committed). Without anything to prepare that is cut_and_sort of the scans.
Partition prepared_partition(JobContext& context);

/// Whether the job asks for clean-up, or its scans for normals.
bool needs_preparation(const InputContext& context);

/// What was measured of the scans, and what clean-up follows from it: with prepare.auto what is
/// applied, otherwise (in `reason`) what would have been.
PrepareFacts clean_up_for(const PrepareOptions& wanted, const Partition& scans);
/// Whether any stage of the clean-up is on.
bool cleans(const PrepareOptions& options);
/// What decides the side of estimated normals: the first that applies.
Orientation side_of_normals(const NormalOptions& options, std::uint64_t points_without_view);
const char* name_of(Orientation orientation);

/// The stages of the store that the passes use, in their order; the first holds the raw points.
const std::vector<std::string>& raw_stages();

/// Removes what the passes left in the store.
void discard_raw_stages(ChunkStore& store);

/// The scans as they come, for cut_and_sort; `prefix` for the report.
CloudInput scans_as_input(const InputContext& context, const std::string& stage,
                          const std::string& prefix);

}  // namespace orbweave
