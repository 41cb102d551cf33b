// The points of raw scans after cleaning and the estimation of normals, as a stream.
#pragma once

#include <memory>

#include "engine/pipeline/points/orientation_stage.h"
#include "io/points/point_source.h"

namespace orbweave {

/// Streams the cloud's points chunk by chunk, without the directions to scanners. `orientation`
/// may be null: normals are as they should be. All arguments must outlive the source.
std::unique_ptr<PointSource> open_cleaned(const ChunkStore& store, const RawCloud& cloud,
                                          const PatchOrientation* orientation);

}  // namespace orbweave
