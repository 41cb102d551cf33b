// Patches in the chunk store, several loops to a batch.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/holes/hole_pass.h"
#include "engine/pipeline/stage/stages.h"
#include "io/box.h"
#include "io/report/report.h"
#include "io/store/chunk_store.h"

namespace orbweave {

/// New vertices and triangles of a batch of patches; new vertices are kNewVertex + index in the
/// batch.
struct PatchBatch {
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;
  std::vector<double> values;  ///< vertices x attributes
  std::vector<Triangle64> triangles;
  std::vector<std::int32_t> hole;  ///< per triangle
  std::vector<Box> boxes;          ///< per loop, of its patch; empty ones where it stays open
  std::vector<HoleFacts> facts;    ///< per loop
};

/// Adds a loop's patch.
void append_patch(LoopPatch&& patch, const Box& box, PatchBatch& batch);
/// Takes the patches of loops out again; `ids` ascending. What is said of these loops stays.
void drop_patches(std::span<const std::int32_t> ids, PatchBatch& batch);

void commit_patch_batch(ChunkStore& store, ChunkId batch, const PatchBatch& patches,
                        const std::string& stage = kHoleStage);
/// The batch as it was settled (kSettledStage), where it was, else as it was filled.
PatchBatch load_patch_batch(const ChunkStore& store, ChunkId batch);
/// Facts and boxes only.
PatchBatch load_patch_facts(const ChunkStore& store, ChunkId batch);

}  // namespace orbweave
