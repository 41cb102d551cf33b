// The scans of a job as one stream in world coordinates: readers, poses, filters.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "io/point_source.h"

namespace orbweave {

/// Whether normals are estimated: the job says so, or leaves it open and the first scan has none.
bool estimates_normals(const InputContext& context);

/// Opens the job's scans. They carry normals of the files or, where these are to be estimated, none
/// but the direction to the scanner where that may decide their side. Throws Error (bad input).
std::unique_ptr<PointSource> open_scans(const InputContext& context,
                                        std::vector<std::string>* notes = nullptr);

}  // namespace orbweave
