// The points that a chunk's surface is computed from.
#pragma once

#include "engine/pipeline/stage/partition.h"
#include "engine/stitching/chunk_mesh.h"
#include "io/stop_token.h"
#include "io/store/chunk_store.h"

namespace orbweave {

/// A chunk's points and those of its halo, in canonical order.
ChunkPoints load_chunk_with_halo(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                                 double halo, const StopToken* stop = nullptr);

}  // namespace orbweave
