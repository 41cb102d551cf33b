// What the results of each stage depend on: a text of lines "name = value". A stage whose text
// differs from the one that its stored results were made under is computed again, and the lines
// that differ say why. A budget or a number of threads is no such thing: results are the same.
// Every key is a function of its arguments; none looks at a file.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// A line of a key.
std::string key_line(const std::string& name, const std::string& value);
/// Tells apart what was cut differently under the same key.
std::string chunks_line(const Partition& partition);

/// The scans as they come, in chunks.
std::string raw_points_key(const ResolvedJob& job);
/// The points that are reconstructed: also the cleaning and the normals.
std::string points_key(const ResolvedJob& job);
/// Whether points that are whole under the key `stored` are those of the key `wanted`: it is the
/// same, or they were measured for automatic radii as well, and radii are given now.
bool serve_for(std::string_view stored, std::string_view wanted);
/// `points_key`: the key that the points were stored under. The scans may have changed, or gone,
/// since the points were read.
std::string mesh_key(const ResolvedJob& job, const std::string& points_key,
                     const Partition& partition, std::span<const double> radii);
/// The Power Crust of points that were stored under `points_key`.
std::string power_crust_key(const ResolvedJob& job, const std::string& points_key);
/// Holes to be filled need the boundary of the whole mesh.
std::string stitch_key(const ResolvedJob& job, const std::string& mesh_key);
std::string hole_key(const ResolvedJob& job, const std::string& mesh_key);
std::string check_key(const ResolvedJob& job, const std::string& mesh_key);
/// Everything that a job's outputs depend on, and the outputs as they lie there.
std::string outputs_key(const ResolvedJob& job, std::span<const InputStamp> outputs);

/// Everything that the processes of a team have to agree on.
std::string team_key(const Job& job);

/// What has changed from one key to another: "partition.chunk_points changed from 5000 to 8000".
std::string key_changes(std::string_view before, std::string_view after);

}  // namespace orbweave
