// The beginning of a stage: what an earlier run stored is kept where it still holds, and removed
// with all that follows from it where it does not.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/pipeline/stage/stage_runner.h"
#include "io/error.h"

namespace orbweave {

/// What the results that are there depend on. Throws CorruptResult where that is damaged or gone,
/// Error (resource) where the stage is gone as well.
std::string stored_key(const ChunkStore& store, const std::string& stage);

/// Whether the points of the stage are whole, and those that are wanted under the key.
bool holds_points(const ChunkStore& store, const std::string& stage, const std::string& key);

/// Declares what `stage` depends on. Where that has changed, what is stored of it and of all
/// stages after it is removed, and a note says what changed. Only the leader calls it.
void begin_stage(StageRunner& runner, const std::string& stage, const std::string& key);

/// The same for what has to be made anew for another reason, which the note gives.
void begin_anew(StageRunner& runner, const std::string& stage, const std::string& key,
                const std::string& reason);

/// Why chunks of up to `largest` of so many points, which were cut for a budget of `made_for`
/// bytes, are too large for the job's budget; empty where they are not.
std::string reason_not_to_fit(const ResolvedJob& job, std::uint64_t made_for, std::uint64_t largest,
                              std::uint64_t points, const PointSchema& schema);

/// Removes stored points whose chunks are too large for a budget that has become smaller, and says
/// so. Only the leader calls it.
void drop_what_does_not_fit(StageRunner& runner, const std::string& stage, const std::string& key);

/// Throws Error (bad input) where the scans are no longer what the stage was begun with. Looks at
/// the scans again.
void check_unchanged(const StageRunner& runner, const std::string& stage);

/// Throws Error (bad input) where the error is about bad input and a scan has changed since the run
/// began: a file that is being written or copied breaks off anywhere.
void tell_of_changed_input(const ResolvedJob& job, const Error& error);

/// The outputs as they lie there now.
std::vector<InputStamp> stamps_of_outputs(const Job& job);

}  // namespace orbweave
