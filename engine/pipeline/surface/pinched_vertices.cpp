#include "engine/pipeline/surface/pinched_vertices.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "engine/holes/loops/split_vertices.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Triangles of the patches at pinched vertices, by vertex, then in the order of the batches. New
/// vertices are counted over all batches.
std::vector<TriangleAt> patched_triangles(std::span<const std::uint64_t> pinched,
                                          const ChunkStore& store, ChunkId batches,
                                          const StopToken& stop) {
  struct OfBatch {
    std::vector<TriangleAt> triangles;
    std::uint64_t new_vertices = 0;
  };
  std::vector<OfBatch> of_batch(batches);
  for_each_whole(of_batch.size(), [&](std::size_t batch) {
    stop.check();
    const PatchBatch patches = load_patch_batch(store, static_cast<ChunkId>(batch));
    of_batch[batch].new_vertices = patches.positions.size();
    for (const Triangle64& t : patches.triangles)
      for (const std::uint64_t vertex : t)
        if (vertex < kNewVertex && std::binary_search(pinched.begin(), pinched.end(), vertex))
          of_batch[batch].triangles.push_back({vertex, t});
  });
  std::vector<TriangleAt> patched;
  std::uint64_t base = 0;
  for (const OfBatch& some : of_batch) {
    for (TriangleAt at : some.triangles) {
      for (std::uint64_t& vertex : at.triangle) vertex += vertex >= kNewVertex ? base : 0;
      patched.push_back(at);
    }
    base += some.new_vertices;
  }
  std::stable_sort(patched.begin(), patched.end(),
                   [](const TriangleAt& a, const TriangleAt& b) { return a.vertex < b.vertex; });
  return patched;
}

void add_triangles_at(std::uint64_t vertex, std::span<const TriangleAt> of_all,
                      std::vector<Triangle64>& around) {
  const auto [first, last] = std::equal_range(
      of_all.begin(), of_all.end(), TriangleAt{vertex, {}},
      [](const TriangleAt& a, const TriangleAt& b) { return a.vertex < b.vertex; });
  for (auto at = first; at != last; ++at) around.push_back(at->triangle);
}

/// What meets at a pinched vertex, and the number of the fan that each triangle lies in.
struct FansAt {
  std::vector<Triangle64> around;
  std::vector<std::uint32_t> group;
};

FansAt fans_at(std::uint64_t vertex, std::span<const TriangleAt> scanned,
               std::span<const TriangleAt> patched) {
  FansAt fans;
  add_triangles_at(vertex, scanned, fans.around);
  add_triangles_at(vertex, patched, fans.around);
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

SplitVertices split_pinched(std::span<const std::uint64_t> pinched, const StoredSurface& surface,
                            const ChunkStore& store, ChunkId batches, std::size_t memory_bytes,
                            const StopToken& stop) {
  SplitVertices split;
  if (pinched.empty()) return split;
  const std::vector<TriangleAt> patched = patched_triangles(pinched, store, batches, stop);
  // A dozen triangles, twice: as they are found, and in fans.
  constexpr std::size_t kBytesPerVertex = 1024, kLeastHeld = 4096, kGrain = 64;
  const std::size_t held =
      std::min(pinched.size(), std::max(kLeastHeld, memory_bytes / kBytesPerVertex));
  std::vector<FansAt> fans(held);
  for (std::size_t first = 0; first < pinched.size(); first += held) {
    const auto part = pinched.subspan(first, std::min(held, pinched.size() - first));
    const std::vector<TriangleAt> scanned = surface.collect_triangles_at(part, stop);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, part.size(), kGrain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        stop.check();
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          fans[i] = fans_at(part[i], scanned, patched);
                      });
    for (std::size_t i = 0; i < part.size(); ++i) split_at(part[i], fans[i], split);
  }
  std::sort(split.splits.begin(), split.splits.end());
  return split;
}

}  // namespace orbweave
