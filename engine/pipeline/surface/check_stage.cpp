#include "engine/pipeline/surface/check_stage.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/geometry/crossing_pairs.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "partition/canonical_order.h"
#include "partition/radix_sort.h"
#include "partition/root_cube.h"

namespace orbweave {
namespace {

/// Calls visit(items) for the cells of an octree that hold at most so many of the items, which are
/// sorted by their Morton codes. All agree from bit `bits` upwards.
template <class Visit>
void for_each_cell(std::span<const KeyIndex> items, int bits, std::size_t most,
                   const Visit& visit) {
  if (items.empty()) return;
  if (items.size() <= most || bits == 0) return visit(items);
  const int shift = bits - 3;
  while (!items.empty()) {
    const std::uint64_t cell = items.front().key >> shift;
    const auto end = std::partition_point(items.begin(), items.end(), [&](const KeyIndex& item) {
      return item.key >> shift == cell;
    });
    const auto count = static_cast<std::size_t>(end - items.begin());
    for_each_cell(items.first(count), shift, most, visit);
    items = items.subspan(count);
  }
}

/// Triangles of several chunks and patches in numbers of their own.
class GatheredTriangles {
 public:
  GatheredTriangles(const StoredSurface& mesh, const Partition& partition, ChunkId chunk)
      : mesh_(mesh), first_(partition.first_vertex[chunk]), positions_(mesh.positions_of(chunk)) {
    own_ = positions_.size();
  }

  std::size_t size() const { return triangles_.size(); }

  /// Adds the surface of a chunk: what comes near the places, or all of it.
  void add_surface(ChunkId chunk, const BoxTree& places) {
    mesh_.triangles_near(chunk, places, triangles_);
    hole_.resize(triangles_.size(), 0);
  }
  void add_surface(ChunkId chunk) {
    mesh_.triangles_of(chunk, triangles_);
    hole_.resize(triangles_.size(), 0);
  }

  /// Adds the patches of these holes, which lie in one batch. Triangles of new vertices alone whose
  /// boxes are not near are left out.
  template <class IsNear>
  void add_patches(const ChunkStore& store, std::span<const PatchPlace> places,
                   const IsNear& is_near) {
    const PatchBatch batch = load_patch_batch(store, places.front().batch);
    std::vector<std::int32_t> ids;
    for (const PatchPlace& place : places) ids.push_back(place.hole);
    std::sort(ids.begin(), ids.end());
    const std::uint64_t base = added_.size();
    added_.insert(added_.end(), batch.positions.begin(), batch.positions.end());
    for (std::size_t t = 0; t < batch.triangles.size(); ++t) {
      if (!std::binary_search(ids.begin(), ids.end(), batch.hole[t])) continue;
      Triangle64 triangle = batch.triangles[t];
      Box box;
      std::size_t new_vertices = 0;
      for (const std::uint64_t vertex : triangle) {
        if (vertex < kNewVertex) continue;
        box.extend(batch.positions[vertex - kNewVertex]);
        ++new_vertices;
      }
      if (new_vertices == triangle.size() && !is_near(box)) continue;
      for (std::uint64_t& vertex : triangle) vertex += vertex >= kNewVertex ? base : 0;
      triangles_.push_back(triangle);
      hole_.push_back(batch.hole[t]);
    }
  }

  /// Boxes of a few triangles each, close to one another, that hold the patches of some holes.
  /// `holes` ascend. One box around a patch that is as wide as the scan would hold the whole
  /// surface.
  std::vector<Box> boxes_within(std::span<const std::int32_t> holes) const {
    constexpr std::size_t kGroup = 16;
    constexpr int kMortonBits = 63;
    if (holes.empty()) return {};
    const std::vector<std::uint64_t> others = other_vertices();
    std::vector<Vec3> places(others.size());
    mesh_.positions(others, places);
    const auto position = [&](std::uint64_t v) {
      if (v >= kNewVertex) return added_[v - kNewVertex];
      if (v - first_ < own_) return positions_[v - first_];
      return places[static_cast<std::size_t>(std::lower_bound(others.begin(), others.end(), v) -
                                             others.begin())];
    };
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t t = 0; t < triangles_.size(); ++t)
      if (std::binary_search(holes.begin(), holes.end(), hole_[t])) wanted.push_back(t);
    if (wanted.empty()) return {};
    Box all;
    for (const std::uint32_t t : wanted) all.extend(position(triangles_[t][0]));
    const MortonFrame frame(root_cube(all));
    KeyList order(wanted.size());
    for (std::size_t i = 0; i < order.size(); ++i)
      order[i] = {frame.code(position(triangles_[wanted[i]][0])), wanted[i]};
    // Isolated: a thread that waits here must not begin another chunk, whose memory is not free
    // yet.
    tbb::this_task_arena::isolate([&] { radix_sort(order); });
    std::vector<Box> boxes;
    for_each_cell(order, kMortonBits, kGroup, [&](std::span<const KeyIndex> cell) {
      boxes.emplace_back();
      for (const KeyIndex& item : cell)
        for (const std::uint64_t v : triangles_[item.index]) boxes.back().extend(position(v));
    });
    return boxes;
  }

  /// Pairs with one of the first `own` triangles. `all`: pairs of the surface alone, too.
  std::vector<HolePair> crossing(std::size_t own, bool all, const StopToken& stop) {
    number();
    PairsWanted wanted{static_cast<std::uint32_t>(own), {}};
    if (!all) wanted.mark = hole_;
    std::vector<TrianglePair> pairs = crossing_pairs(positions_, numbered_, wanted, &stop);
    // Pairs among the first `own` triangles were found by the first call.
    if (has_crossed_) std::erase_if(pairs, [&](const TrianglePair& pair) { return pair[1] < own; });
    has_crossed_ = true;
    return holes_of_pairs(pairs, hole_);
  }

  /// Drops all triangles but the first `own`.
  void keep_first(std::size_t own) {
    triangles_.resize(own);
    hole_.resize(own);
  }

 private:
  /// Points of other chunks, ascending.
  std::vector<std::uint64_t> other_vertices() const {
    std::vector<std::uint64_t> others;
    for (const Triangle64& t : triangles_)
      for (const std::uint64_t v : t)
        if (v < kNewVertex && v - first_ >= own_) others.push_back(v);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    return others;
  }

  /// Gives every vertex a number: the chunk's own points, other points, new vertices.
  void number() {
    const std::vector<std::uint64_t> others = other_vertices();
    positions_.resize(own_ + others.size());
    numbered_.clear();
    mesh_.positions(others, std::span(positions_).subspan(own_));
    const std::uint64_t first_added = positions_.size();
    positions_.insert(positions_.end(), added_.begin(), added_.end());
    numbered_.reserve(triangles_.size());
    const auto number_of = [&](std::uint64_t v) -> std::uint64_t {
      if (v >= kNewVertex) return first_added + (v - kNewVertex);
      if (v - first_ < own_) return v - first_;
      return own_ + static_cast<std::size_t>(std::lower_bound(others.begin(), others.end(), v) -
                                             others.begin());
    };
    for (const Triangle64& t : triangles_)
      numbered_.push_back({static_cast<std::uint32_t>(number_of(t[0])),
                           static_cast<std::uint32_t>(number_of(t[1])),
                           static_cast<std::uint32_t>(number_of(t[2]))});
  }

  const StoredSurface& mesh_;
  const std::uint64_t first_;
  std::size_t own_ = 0;
  std::vector<Vec3> positions_;
  std::vector<Vec3> added_;
  std::vector<Triangle64> triangles_;
  std::vector<std::int32_t> hole_;  // per triangle; 0: the surface
  std::vector<Triangle> numbered_;
  bool has_crossed_ = false;
};

/// The patches whose loops begin in one chunk.
struct ChunkPatches {
  std::vector<PatchPlace> places;  ///< by batch
  Box box;
};

std::vector<ChunkPatches> patches_by_chunk(std::span<const PatchPlace> patches,
                                           std::size_t chunks) {
  std::vector<ChunkPatches> by_chunk(chunks);
  for (const PatchPlace& place : patches) {
    by_chunk[place.chunk].places.push_back(place);
    by_chunk[place.chunk].box.extend(place.box);
  }
  return by_chunk;
}

/// The patches of a list that come near a place.
template <class IsNear>
std::vector<PatchPlace> patches_near(const ChunkPatches& patches, const IsNear& is_near) {
  std::vector<PatchPlace> near;
  if (!is_near(patches.box)) return near;
  for (const PatchPlace& place : patches.places)
    if (is_near(place.box)) near.push_back(place);
  return near;
}

/// Adds patches, batch by batch.
template <class IsNear>
void add_patches(const ChunkStore& store, std::span<const PatchPlace> places, const IsNear& is_near,
                 GatheredTriangles& gathered) {
  for (std::size_t i = 0, end = 0; i < places.size(); i = end) {
    for (end = i; end < places.size() && places[end].batch == places[i].batch;) ++end;
    gathered.add_patches(store, places.subspan(i, end - i), is_near);
  }
}

std::vector<Box> boxes_of(std::span<const PatchPlace> places) {
  std::vector<Box> boxes;
  for (const PatchPlace& place : places) boxes.push_back(place.box);
  return boxes;
}

class Check {
  /// A patch of so many triangles is held by many boxes, and counts in the memory of a chunk.
  static constexpr std::uint64_t kLarge = 10'000;
  /// Triangles of other chunks that are held at once.
  static constexpr std::size_t kMostOthers = 1'000'000;

 public:
  Check(const CheckInputs& inputs, StageRunner& runner)
      : inputs_(inputs),
        runner_(runner),
        patches_(
            patches_by_chunk(inputs.patches, inputs.surface.partition.octree.chunks().size())) {
    for (const PatchPlace& place : inputs.patches)
      if (place.triangles >= kLarge) large_patches_.push_back(place);
  }

  void run(StageClock& clock) {
    const Partition& partition = inputs_.surface.partition;
    std::vector<ChunkWork> tasks;
    for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
      // Positions, triangles in two numberings and their boxes, of the chunk and what is near it.
      constexpr std::size_t kPerPoint = 300, kPerPatchTriangle = 180;
      const std::uint64_t points = partition.points_in(chunk);
      const std::uint64_t bytes = kPerPoint * points + kPerPatchTriangle * patch_triangles(chunk);
      tasks.push_back({chunk, bytes, points, points});
    }
    share_chunks(
        runner_, clock, kCheckStage, std::move(tasks), inputs_.memory_bytes,
        [this](ChunkId chunk) { commit(chunk, crossing_at(chunk)); }, Durability::kFollows);
  }

  std::vector<HolePair> all_pairs() const {
    std::vector<HolePair> pairs;
    for (ChunkId chunk = 0; chunk < inputs_.surface.partition.octree.chunks().size(); ++chunk) {
      const auto part = runner_.store.open(kCheckStage, chunk)->read_all<HolePair>("pairs");
      pairs.insert(pairs.end(), part.begin(), part.end());
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }

 private:
  /// Triangles of large patches that the chunk is checked with. Small patches do not count beside
  /// the chunk's points.
  std::uint64_t patch_triangles(ChunkId chunk) const {
    const double reach = longest_edge(inputs_.surface.radii.values);
    const Box surface = inputs_.surface.partition.octree.chunks()[chunk].box.grown(reach);
    const Box& own = patches_[chunk].box;
    std::uint64_t triangles = 0;
    for (const PatchPlace& place : large_patches_) {
      const bool is_near = place.box.intersects(surface) || place.box.intersects(own);
      if (place.chunk == chunk || (place.chunk > chunk && is_near)) triangles += place.triangles;
    }
    return triangles;
  }

  /// Pairs of the chunk's triangles and patches with each other and with those of later chunks.
  /// Unless the job asks for all pairs, only triangles near patches are looked at.
  std::vector<HolePair> crossing_at(ChunkId chunk) const {
    const std::vector<Chunk>& chunks = inputs_.surface.partition.octree.chunks();
    const bool all = runner_.job.output.check_surface;
    const double reach = longest_edge(inputs_.surface.radii.values);
    const ChunkPatches& own = patches_[chunk];
    const Box surface = chunks[chunk].box.grown(reach);
    const auto is_near = [&](const Box& box) {
      return box.intersects(surface) || box.intersects(own.box);
    };
    std::vector<PatchPlace> others;
    for (ChunkId other = chunk + 1; other < chunks.size(); ++other) {
      const std::vector<PatchPlace> near = patches_near(patches_[other], is_near);
      others.insert(others.end(), near.begin(), near.end());
    }
    if (!all && own.places.empty() && others.empty()) return {};
    GatheredTriangles gathered(inputs_.mesh, inputs_.surface.partition, chunk);
    add_patches(
        runner_.store, own.places, [](const Box&) { return true; }, gathered);
    std::vector<Box> near_own;
    std::vector<std::int32_t> large;
    for (const PatchPlace& place : own.places) {
      if (place.triangles >= kLarge)
        large.push_back(place.hole);
      else
        near_own.push_back(place.box);
    }
    std::sort(large.begin(), large.end());
    const std::vector<Box> within = gathered.boxes_within(large);
    near_own.insert(near_own.end(), within.begin(), within.end());
    if (all) {
      gathered.add_surface(chunk);
      near_own.push_back(surface);
    } else {
      std::vector<Box> near_any = boxes_of(others);
      near_any.insert(near_any.end(), near_own.begin(), near_own.end());
      gathered.add_surface(chunk, BoxTree(near_any));
    }
    const std::size_t count = gathered.size();
    const BoxTree places(near_own);
    std::vector<HolePair> pairs;
    const auto cross = [&] {
      const std::vector<HolePair> more = gathered.crossing(count, all, runner_.stop);
      pairs.insert(pairs.end(), more.begin(), more.end());
      gathered.keep_first(count);
    };
    for (ChunkId other = chunk + 1; other < chunks.size(); ++other) {
      if (!places.meets(chunks[other].box.grown(reach))) continue;
      gathered.add_surface(other, places);
      // A patch may reach over the whole scan: the surface near it is read a part at a time.
      if (gathered.size() - count > kMostOthers) cross();
    }
    add_patches(runner_.store, others, is_near, gathered);
    cross();
    return pairs;
  }

  void commit(ChunkId chunk, const std::vector<HolePair>& pairs) const {
    const ArrayView arrays[] = {
        {"pairs", ScalarType::kInt32, 2, pairs.size(), pairs.data()},
    };
    runner_.store.commit(kCheckStage, chunk, arrays);
  }

  const CheckInputs& inputs_;
  StageRunner& runner_;
  const std::vector<ChunkPatches> patches_;
  std::vector<PatchPlace> large_patches_;
};

}  // namespace

CheckResult check_crossings(const CheckInputs& inputs, StageRunner& runner) {
  const ResolvedJob& job = runner.job;
  CheckResult result;
  if (inputs.patches.empty() && !job.output.check_surface) return result;
  StageClock clock(runner, Stage::kCheck, inputs.surface.partition.octree.chunks().size(),
                   "chunks");
  by_root(runner, [&] {
    begin_stage(runner, kCheckStage,
                check_key(job, stored_mesh_key(job, runner.store, inputs.surface)));
  });
  Check check(inputs, runner);
  check.run(clock);
  const std::vector<HolePair> pairs = check.all_pairs();
  if (!job.fill.allow_intersections) result.dropped = patches_to_drop(pairs);
  std::uint64_t left = 0;
  for (const auto& [first, second] : pairs) {
    if (result.dropped.contains(first) || result.dropped.contains(second)) continue;
    ++left;
    result.patch_crossing_pairs += second != 0 ? 1 : 0;
  }
  if (job.output.check_surface) result.crossing_pairs = left;
  return result;
}

void drop_crossing_patches(const DroppedHoles& dropped, ChunkId batches, StageRunner& runner) {
  ChunkStore& store = runner.store;
  store.discard_stage(kSettledStage);
  for (ChunkId batch = 0; batch < batches && !dropped.empty(); ++batch) {
    PatchBatch facts = load_patch_facts(store, batch);
    std::vector<std::int32_t> ids;
    for (const HoleFacts& hole : facts.facts)
      if (dropped.contains(hole.id)) ids.push_back(hole.id);
    if (ids.empty()) continue;
    std::sort(ids.begin(), ids.end());
    PatchBatch patches = load_patch_batch(store, batch);
    drop_patches(ids, patches);
    for (HoleFacts& hole : patches.facts) {
      const auto found = dropped.find(hole.joined_to != 0 ? hole.joined_to : hole.id);
      if (found == dropped.end()) continue;
      hole.filled = false;
      hole.joined_to = 0;
      hole.method.clear();
      hole.reason = found->second;
    }
    commit_patch_batch(store, batch, patches, kSettledStage);
  }
  show_commits(runner);
}

}  // namespace orbweave
