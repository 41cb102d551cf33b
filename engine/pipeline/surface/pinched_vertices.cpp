#include "engine/pipeline/surface/pinched_vertices.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

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

/// What meets at a pinched vertex, and the number of the fan that each triangle lies in.
struct FansAt {
  std::vector<Triangle64> around;
  std::vector<std::uint32_t> group;
};

FansAt fans_at(std::uint64_t vertex, std::span<const AtVertex> patched, const Surface& surface) {
  FansAt fans;
  surface.triangles_at(vertex, fans.around);
  const auto [first, last] =
      std::equal_range(patched.begin(), patched.end(), AtVertex{vertex, {}},
                       [](const AtVertex& a, const AtVertex& b) { return a.vertex < b.vertex; });
  for (auto at = first; at != last; ++at) fans.around.push_back(at->triangle);
  fans.group = fan_groups(fans.around, vertex);
  return fans;
}

void split_at(std::uint64_t vertex, const FansAt& fans, SplitVertices& split) {
  const std::uint64_t first_copy = split.copies.size();
  for (std::size_t i = 0; i < fans.group.size(); ++i) {
    if (fans.group[i] == 0) continue;
    const std::uint64_t copy = first_copy + fans.group[i] - 1;
    if (copy == split.copies.size()) split.copies.push_back(vertex);
    split.splits.push_back({fans.around[i], vertex, CopyIndex{copy}});
  }
}

}  // namespace

SplitVertices split_pinched(std::span<const std::uint64_t> pinched, const Surface& surface,
                            const ChunkStore& store, ChunkId batches, const StopToken& stop) {
  SplitVertices split;
  if (pinched.empty()) return split;
  const std::vector<AtVertex> patched = patched_triangles(pinched, store, batches, stop);
  // Vertices whose fans are held at a time.
  constexpr std::size_t kHeld = 4096, kGrain = 64;
  std::vector<FansAt> fans(std::min(kHeld, pinched.size()));
  for (std::size_t first = 0; first < pinched.size(); first += kHeld) {
    stop.check();
    const std::size_t count = std::min(kHeld, pinched.size() - first);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          fans[i] = fans_at(pinched[first + i], patched, surface);
                      });
    for (std::size_t i = 0; i < count; ++i) split_at(pinched[first + i], fans[i], split);
  }
  std::sort(split.splits.begin(), split.splits.end());
  return split;
}

}  // namespace orbweave
