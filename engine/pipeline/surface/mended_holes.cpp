#include "engine/pipeline/surface/mended_holes.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/pipeline/surface/patch_batch.h"

namespace orbweave {
namespace {

/// The facts of all loops and where their patches are stored.
struct StoredPatches {
  std::vector<HoleFacts> holes;
  std::vector<Box> boxes;
  std::vector<ChunkId> batch;  // per loop
};

StoredPatches list_patches(const MendInputs& inputs, StageRunner& runner) {
  StoredPatches patches;
  patches.holes = inputs.plan.all_facts();
  patches.boxes.resize(patches.holes.size());
  patches.batch.resize(patches.holes.size(), 0);
  for (ChunkId batch = 0; batch < inputs.batches; ++batch) {
    runner.stop.check();
    PatchBatch stored = load_patch_facts(runner.store, batch);
    for (std::size_t i = 0; i < stored.facts.size(); ++i) {
      const auto l = static_cast<std::size_t>(stored.facts[i].id - inputs.plan.first_id);
      patches.boxes[l] = stored.boxes[i];
      patches.batch[l] = batch;
      patches.holes[l] = std::move(stored.facts[i]);
    }
  }
  return patches;
}

/// One loop's patch out of its batch.
LoopPatch patch_in(const PatchBatch& batch, std::int32_t id) {
  LoopPatch patch;
  std::size_t first = 0, i = 0;
  for (; batch.facts[i].id != id; ++i) first += batch.facts[i].points_added;
  const std::size_t count = batch.facts[i].points_added;
  const std::size_t channels =
      batch.positions.empty() ? 0 : batch.values.size() / batch.positions.size();
  const auto rows = [&](const auto& all, std::size_t width) {
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(first * width);
    return std::vector(begin, begin + static_cast<std::ptrdiff_t>(count * width));
  };
  patch.positions = rows(batch.positions, 1);
  patch.normals = rows(batch.normals, 1);
  patch.values = rows(batch.values, channels);
  for (std::size_t t = 0; t < batch.triangles.size(); ++t) {
    if (batch.hole[t] != id) continue;
    Triangle64 triangle = batch.triangles[t];
    for (std::uint64_t& vertex : triangle) vertex -= vertex >= kNewVertex ? first : 0;
    patch.triangles.push_back(triangle);
  }
  patch.facts = batch.facts[i];
  return patch;
}

/// The batch that was asked for last. Patches next to each other mostly lie in one batch, and a
/// fault asks for all that are around it.
class LastBatch {
 public:
  explicit LastBatch(ChunkStore& store) : store_(store) {}
  const PatchBatch& load(ChunkId batch) {
    if (!loaded_ || number_ != batch) loaded_ = load_patch_batch(store_, batch);
    number_ = batch;
    return *loaded_;
  }

 private:
  ChunkStore& store_;
  std::optional<PatchBatch> loaded_;
  ChunkId number_ = 0;
};

Box box_of(const LoopPatch& patch, const Surface& surface) {
  Box box;
  for (const Triangle64& t : patch.triangles)
    for (const std::uint64_t v : t)
      box.extend(v < kNewVertex ? surface.position(v) : patch.positions[v - kNewVertex]);
  return box;
}

void drop_replaced(const Mended& mended, const MendInputs& inputs, ChunkStore& store) {
  for (ChunkId batch = 0; batch < inputs.batches; ++batch) {
    const PatchBatch facts = load_patch_facts(store, batch);
    std::vector<std::int32_t> ids;
    for (const HoleFacts& hole : facts.facts)
      if (mended.is_replaced[static_cast<std::size_t>(hole.id - inputs.plan.first_id)] != 0)
        ids.push_back(hole.id);
    if (ids.empty()) continue;
    std::sort(ids.begin(), ids.end());
    PatchBatch patches = load_patch_batch(store, batch);
    drop_patches(ids, patches);
    for (HoleFacts& hole : patches.facts) {
      if (!std::binary_search(ids.begin(), ids.end(), hole.id)) continue;
      hole.filled = false;
      hole.joined_to = 0;
      hole.method.clear();
    }
    commit_patch_batch(store, batch, patches, kSettledStage);
  }
}

}  // namespace

Mended mend_holes(const MendInputs& inputs, StageRunner& runner) {
  const HolePlan& plan = inputs.plan;
  if (runner.job.fill.allow_intersections || !plan.is_object) return {};
  Faults faults;
  faults.pinched = pinches_of_solids(plan, inputs.pinched, inputs.fans);
  bool any_solid = false;
  for (std::size_t l = 0; l < plan.loops.size() && !any_solid; ++l)
    any_solid = plan.is_wanted[l] != 0 && plan.is_of_solid(l);
  if (!any_solid && faults.pinched.empty()) return {};
  StoredPatches patches = list_patches(inputs, runner);
  faults.loops = open_loops_of_solids(plan, patches.holes);
  const Partition& partition = inputs.surface.partition;
  const double reach = longest_edge(inputs.surface.radii.values);
  const auto scanned_near = [&](const Box& box, std::vector<Triangle64>& out) {
    const std::vector<Chunk>& chunks = partition.octree.chunks();
    const BoxTree place(std::span(&box, 1));
    for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk)
      if (chunks[chunk].box.grown(reach).intersects(box))
        inputs.mesh.triangles_near(chunk, place, out);
  };
  LastBatch last(runner.store);
  const auto patch_of = [&](std::size_t l) {
    return patch_in(last.load(patches.batch[l]), patches.holes[l].id);
  };
  const FilledSurface filled{inputs.mesh,
                             scanned_near,
                             plan.loops,
                             patches.holes,
                             plan.first_id,
                             plan.is_wanted,
                             std::move(patches.boxes),
                             patch_of};
  return mend_solids(filled, faults, runner.job.fill, &runner.stop);
}

void store_mended(const Mended& mended, const MendInputs& inputs, StageRunner& runner) {
  ChunkStore& store = runner.store;
  if (mended.empty()) return;
  drop_replaced(mended, inputs, store);
  PatchBatch batch;
  for (const LoopPatch& patch : mended.patches)
    append_patch(LoopPatch(patch), box_of(patch, inputs.mesh), batch);
  for (const HoleFacts& hole : mended.joined) {
    LoopPatch none;
    none.facts = hole;
    append_patch(std::move(none), {}, batch);
  }
  commit_patch_batch(store, inputs.batches, batch, kSettledStage);
  show_commits(runner);
}

}  // namespace orbweave
