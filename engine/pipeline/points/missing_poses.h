// Scans without poses that seem to have some.
#pragma once

#include <string>

#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// Where a job has several scans and no pose, and a .conf or .aln that names one of them lies
/// beside them: "bun.conf beside the scans names bun000.ply, ..."; empty otherwise. A file that
/// cannot be read names nothing.
std::string objection_to_missing_poses(const ResolvedJob& job);

}  // namespace orbweave
