// Scans without poses that seem to have some.
#pragma once

#include <string>

#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// Of a job that has several scans and no pose: "the scans are taken to fit as they are, but
/// bun.conf names bun000.ply: ..." where such a file lies beside the scans (poses_beside); empty
/// otherwise.
std::string objection_to_missing_poses(const ResolvedJob& job);

}  // namespace orbweave
