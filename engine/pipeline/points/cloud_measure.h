// What the second pass over a cloud measures: spacing, radii and, of scans, thickness of the layers
// and reach of normals.
#pragma once

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/spacing/automatic_radii.h"

namespace orbweave {

/// Returns a partition with the measured members alone. `sampler` ends without duplicates.
Partition measure(const CloudInput& input, SpacingSampler& sampler, const RunControl& control);

/// Chunks as large as the radii that were found ask for, where those are not the ones expected.
Octree final_octree(const ResolvedJob& job, const CountedCloud& cloud, const Partition& measured);

}  // namespace orbweave
