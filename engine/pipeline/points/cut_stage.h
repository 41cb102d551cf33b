// From points to chunks: count, bin, measure, sort. The points of every chunk end in the chunk
// store, in canonical order.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Points that are cut into chunks.
struct CutPoints {
  Partition partition;
  /// Most that the work directory and the output were expected to hold before anything was binned;
  /// 0: not predicted, because an earlier run cut the points.
  std::uint64_t predicted_disk_bytes = 0;
};

/// All passes. The points are in the store then; the partition is not committed yet.
CutPoints cut_and_sort(const CloudInput& input, StageRunner& runner);

/// Declares what the points of `stage` depend on; returns what an earlier run left of them.
std::optional<Partition> begin_partition(StageRunner& runner, const CutStages& stages,
                                         const std::string& key);
/// All members make it together; the leader's is committed, and everybody gets that. What it was
/// cut from goes.
CutPoints partition_by_team(StageRunner& runner, const CutStages& stages,
                            const std::function<CutPoints()>& make);

}  // namespace orbweave
