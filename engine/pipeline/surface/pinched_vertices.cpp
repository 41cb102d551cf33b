#include "engine/pipeline/surface/pinched_vertices.h"

#include <algorithm>

#include "engine/holes/loops/split_vertices.h"
#include "engine/pipeline/surface/patch_batch.h"

namespace orbweave {
namespace {

/// A patch's triangle at a pinched vertex.
struct AtVertex {
  std::uint64_t vertex = 0;
  Triangle64 triangle{};
};

/// By vertex, then in the order of the batches. New vertices are counted over all batches.
std::vector<AtVertex> patched_triangles(std::span<const std::uint64_t> pinched,
                                        const ChunkStore& store, ChunkId batches,
                                        const StopToken& stop) {
  std::vector<AtVertex> patched;
  std::uint64_t base = 0;
  for (ChunkId batch = 0; batch < batches; ++batch) {
    stop.check();
    const PatchBatch patches = load_patch_batch(store, batch);
    for (Triangle64 t : patches.triangles) {
      for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? base : 0;
      for (const std::uint64_t vertex : t) {
        if (std::binary_search(pinched.begin(), pinched.end(), vertex))
          patched.push_back({vertex, t});
      }
    }
    base += patches.positions.size();
  }
  std::stable_sort(patched.begin(), patched.end(),
                   [](const AtVertex& a, const AtVertex& b) { return a.vertex < b.vertex; });
  return patched;
}

void split_at(std::uint64_t vertex, std::span<const Triangle64> patch_triangles,
              const Surface& surface, SplitVertices& split) {
  std::vector<Triangle64> around;
  surface.triangles_at(vertex, around);
  around.insert(around.end(), patch_triangles.begin(), patch_triangles.end());
  const std::vector<std::uint32_t> group = fan_groups(around, vertex);
  const std::uint64_t first_copy = split.copies.size();
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group[i] == 0) continue;
    const std::uint64_t copy = first_copy + group[i] - 1;
    if (copy == split.copies.size()) split.copies.push_back(vertex);
    split.splits.push_back({around[i], vertex, CopyIndex{copy}});
  }
}

}  // namespace

SplitVertices split_pinched(std::span<const std::uint64_t> pinched, const Surface& surface,
                            const ChunkStore& store, ChunkId batches, const StopToken& stop) {
  SplitVertices split;
  if (pinched.empty()) return split;
  const std::vector<AtVertex> patched = patched_triangles(pinched, store, batches, stop);
  std::vector<Triangle64> here;
  auto at = patched.begin();
  for (const std::uint64_t vertex : pinched) {
    here.clear();
    for (; at != patched.end() && at->vertex == vertex; ++at) here.push_back(at->triangle);
    split_at(vertex, here, surface, split);
  }
  std::sort(split.splits.begin(), split.splits.end());
  return split;
}

}  // namespace orbweave
