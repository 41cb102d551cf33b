// Scans that a job's patterns pass over for a capital letter.
#pragma once

#include <string>

#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// "B.LAZ and 2 more match no pattern of input.files, but for capital and small letters: ...";
/// empty where there is no such file.
std::string objection_to_missed_scans(const ResolvedJob& job);

}  // namespace orbweave
