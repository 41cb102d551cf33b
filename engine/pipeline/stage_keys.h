// What the results of each stage depend on: a text of lines "name = value". A stage whose text
// differs from the one that its stored results were made under is computed again, and the lines
// that differ say why. A budget or a number of threads is no such thing: results are the same.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/pipeline/partition_stage.h"

namespace orbweave {

/// A line of a key.
std::string key_line(const std::string& name, const std::string& value);
/// Tells apart what was cut differently under the same key.
std::string chunks_line(const Partition& partition);

/// The scans as they come, in chunks.
std::string raw_points_key(const InputContext& context);
/// The points that are reconstructed: also the clean-up and the normals.
std::string points_key(const InputContext& context);
std::string mesh_key(const JobContext& context, const Partition& partition,
                     const std::vector<double>& radii);
/// Holes to be filled need the boundary of the whole mesh.
std::string stitch_key(const JobContext& context, const Partition& partition,
                       const std::vector<double>& radii);
std::string hole_key(const JobContext& context, const Partition& partition,
                     const std::vector<double>& radii);
/// Everything that a job's outputs depend on, and the outputs as they lie there now.
std::string outputs_key(const InputContext& context);

/// What has changed from one key to another: "partition.chunk_points changed from 5000 to 8000".
std::string key_changes(std::string_view before, std::string_view after);

/// Declares what `stage` depends on. Where that has changed, what is stored of it and of all
/// stages after it is removed, and a note says what changed. Only the leader calls it.
void begin_stage(JobContext& context, const std::string& stage, const std::string& key);

/// The same for what has to be made anew for another reason, which the note gives.
void begin_anew(JobContext& context, const std::string& stage, const std::string& key,
                const std::string& reason);

/// Why chunks of up to `largest` of so many points, which were cut for a budget of `made_for`
/// bytes, are too large for the job's budget; empty where they are not.
std::string reason_not_to_fit(const InputContext& context, std::uint64_t made_for,
                              std::uint64_t largest, std::uint64_t points,
                              const PointSchema& schema);

/// Removes stored points whose chunks are too large for a budget that has become smaller, and says
/// so. Only the leader calls it.
void drop_what_does_not_fit(JobContext& context, const std::string& stage, const std::string& key);

/// Throws Error (bad input) where the scans are no longer what the stage was begun with.
void check_unchanged(const JobContext& context, const std::string& stage);

}  // namespace orbweave
