// The unit of a scan's lengths.
#pragma once

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// Metres per unit of x: as the job says, or else the scan's coordinate system; 0: not known.
double meters_per_unit(const ResolvedJob& job, const Partition& partition);

}  // namespace orbweave
