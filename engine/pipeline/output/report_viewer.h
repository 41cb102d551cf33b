// The viewer of a small mesh inside the page of its report.
#pragma once

#include <string>

#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// The page of the job's mesh (engine/view/view_page.h), read back from its file. Empty where the
/// mesh is no PLY file, has more than 250,000 triangles, or the budget has no room for its page.
std::string report_viewer(const ResolvedJob& job, const std::string& coordinate_system);

}  // namespace orbweave
