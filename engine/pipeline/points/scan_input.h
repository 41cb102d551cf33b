// The scans of a job as one stream in world coordinates: readers, poses, filters.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/points/point_source.h"

namespace orbweave {

/// Opens the job's scans. They carry normals of the files or, where these are to be estimated, none
/// but the direction to the scanner where that may decide their side. Throws Error (bad input), and
/// (interrupted) as it is read. `job` and `stop` must outlive the result.
std::unique_ptr<PointSource> open_scans(const ResolvedJob& job, const StopToken& stop,
                                        std::vector<std::string>* notes = nullptr);

/// The scans as they come, to be cut into chunks by `stages`. The job and the token of `control`
/// must outlive the result.
CloudInput scans_as_input(const RunControl& control, const CutStages& stages);

}  // namespace orbweave
