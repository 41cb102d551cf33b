// What the stages of the surface start from.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"

namespace orbweave {

/// The ball radii of a job, given or chosen.
struct BallRadii {
  std::vector<double> values;  ///< ascending, world units
  std::string reason;
};

struct SurfaceInputs {
  const Partition& partition;
  const BallRadii& radii;
};

/// The key of the chunks' meshes. Looks into the store for the key of the points.
inline std::string stored_mesh_key(const ResolvedJob& job, const ChunkStore& store,
                                   const SurfaceInputs& inputs) {
  return mesh_key(job, stored_key(store, kPointsStage), inputs.partition, inputs.radii.values);
}

}  // namespace orbweave
