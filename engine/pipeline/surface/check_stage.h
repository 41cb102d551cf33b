// Check stage: looks for triangles of patches that cross the surface or other patches, chunk by
// chunk. Patches that do are taken out. A hole is filled from its neighbourhood alone; what lies
// beyond, and what becomes of the holes beside it, is known only now.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/holes/crossing_patches.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/stored_surface.h"
#include "engine/pipeline/surface/surface_inputs.h"

namespace orbweave {

/// Where the patch of a hole lies.
struct PatchPlace {
  std::int32_t hole = 0;
  ChunkId batch = 0;
  ChunkId chunk = 0;  ///< of the loop's first vertex
  Box box;
  std::uint64_t triangles = 0;  ///< of the patch
};

struct CheckInputs {
  const SurfaceInputs& surface;
  const StoredSurface& mesh;
  std::vector<PatchPlace> patches;  ///< by batch
  std::size_t memory_bytes = 0;     ///< for chunks that are being checked
};

struct CheckResult {
  // Pairs of triangles that cross, once patches are taken out.
  std::uint64_t patch_crossing_pairs = 0;       ///< with a triangle of a patch
  std::optional<std::uint64_t> crossing_pairs;  ///< all; empty: the job does not ask for them
  DroppedHoles dropped;
};

/// The stage. Where fill.allow_intersections says so, pairs are counted and all patches stay.
CheckResult check_crossings(const CheckInputs& inputs, StageRunner& runner);

/// Takes the patches of these holes out of the stored batches, and says why. Only the root calls
/// it.
void drop_crossing_patches(const DroppedHoles& dropped, ChunkId batches, StageRunner& runner);

}  // namespace orbweave
