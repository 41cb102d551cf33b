#include "engine/pipeline/hole_stage.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>
#include <span>

#include "engine/holes/hole_choice.h"
#include "engine/holes/hole_pass.h"
#include "engine/holes/split_vertices.h"
#include "engine/pipeline/memory_forecast.h"
#include "engine/pipeline/stage_keys.h"
#include "engine/pipeline/stored_surface.h"
#include "engine/validation/disjoint_sets.h"
#include "io/memory_watch.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

constexpr const char* kDocument = "batches.json";
/// A batch ends where it has that many loops, or that much work (edges squared).
constexpr std::size_t kBatchLoops = 256;
constexpr std::uint64_t kBatchWork = 100'000;
/// What filling one hole may hold: a dense system of the largest size and its factors.
constexpr std::size_t kHoleBytes = std::size_t{48} << 20;
/// A batch of holes of a few edges, patches and texts included.
constexpr std::size_t kBatchBytes = std::size_t{4} << 20;

/// As many sites as the square of its edges are around a hole; its system has the square of that.
std::size_t bytes_to_fill(std::uint64_t edges) {
  const std::size_t sites =
      std::min<std::uint64_t>(edges, 100) * std::min<std::uint64_t>(edges, 100);
  return std::min(kHoleBytes, kBatchBytes + 3 * sizeof(double) * sites * sites);
}

double area_of(const Surface& surface, const LoopPatch& patch) {
  const auto position = [&](std::uint64_t vertex) {
    return vertex < kNewVertex ? surface.position(vertex) : patch.positions[vertex - kNewVertex];
  };
  double area = 0.0;
  for (const Triangle64& t : patch.triangles) {
    const Vec3 a = position(t[0]);
    area += 0.5 * norm(cross(position(t[1]) - a, position(t[2]) - a));
  }
  return area;
}

std::vector<Piece> pieces_of(const StitchedBoundary& boundary) {
  std::vector<Piece> pieces;
  pieces.reserve(boundary.pieces.size());
  for (const ChunkPiece& piece : boundary.pieces) pieces.push_back({piece.triangles, piece.box});
  return pieces;
}

/// The stage's steps share this.
class HoleStage {
 public:
  HoleStage(JobContext& context, const Partition& partition, const std::vector<double>& radii,
            StitchedBoundary boundary, MeshFacts& facts)
      : context_(context),
        partition_(partition),
        boundary_(std::move(boundary)),
        facts_(facts),
        plan_(plan_memory(context.job.partition.memory_bytes, partition.points(), context.threads(),
                          context.job.partition.chunk_points, partition.schema)),
        surface_(context.store, partition, 2.0 * radii.back(), bytes_for_chunks(), true) {}

  FilledHoles run(const std::string& key) {
    {
      const StageClock clock(context_, "trace", 0, "edges");
      remove_small_pieces();
      surface_.limit_memory(0);
      trace();
      cut_into_batches();
      release_freed_memory();
    }
    plan_for_holes();
    StageClock clock(context_, "holes", batches_.size(), "batches");
    by_leader(context_, [&] {
      begin_stage(context_, kHoleStage, key);
      context_.store.commit_document(kHoleStage, kDocument,
                                     nlohmann::json{{"batches", batches_.size()}}.dump() + "\n");
    });
    fill(clock);
    holes_.vertices = {};
    holes_.islands = {};
    holes_.taken = {};
    split();
    surface_.limit_memory(0);
    release_freed_memory();
    collect();
    update_facts();
    clock.facts().chunks = batches_.size();
    return std::move(result_);
  }

 private:
  struct Batch {
    std::size_t first = 0;  // of the groups
    std::size_t count = 0;
  };

  void remove_small_pieces();
  void remove_piece(const ChunkPiece& piece);
  void find_freed();
  void trace();
  void cut_into_batches();
  std::size_t bytes_for_chunks() const;
  void plan_for_holes();
  ChunkWork work_of(ChunkId batch) const;
  std::uint64_t edges_of_group(std::size_t group) const;
  void fill(StageClock& clock);
  void fill_batch(ChunkId batch);
  void collect();
  void split();
  void split_at(std::uint64_t vertex, std::span<const Triangle64> patch_triangles);
  void close_fans(std::span<const Triangle64> corners);
  std::vector<OpenFan> in_split_numbers(std::vector<OpenFan> fans) const;
  void update_facts();
  bool is_removed(std::uint64_t piece) const {
    return boundary_.pieces[piece].triangles < context_.job.fill.min_triangles;
  }

  JobContext& context_;
  const Partition& partition_;
  StitchedBoundary boundary_;  ///< its fans are fans_, its vertices those of holes_ in the end
  MeshFacts& facts_;
  MemoryPlan plan_;
  StoredSurface surface_;
  FilledHoles result_;
  std::vector<OpenFan> fans_;
  HolePlan holes_;
  std::vector<Batch> batches_;
  double patch_area_ = 0.0;
};

void HoleStage::remove_small_pieces() {
  for (std::uint64_t p = 0; p < boundary_.pieces.size(); ++p) {
    if (is_removed(p)) remove_piece(boundary_.pieces[p]);
  }
  std::sort(result_.removed.begin(), result_.removed.end());
  find_freed();
  surface_.remove(result_.removed);
  fans_ = std::move(boundary_.fans);
  std::erase_if(fans_, [&](const OpenFan& fan) { return is_removed(fan.component); });
}

/// All triangles that hang together with the piece's first one.
void HoleStage::remove_piece(const ChunkPiece& piece) {
  std::set<Triangle64> seen = {piece.first};
  std::vector<Triangle64> next = {piece.first};
  std::vector<Triangle64> around;
  while (!next.empty()) {
    const Triangle64 t = next.back();
    next.pop_back();
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t tail = t[k], head = t[(k + 1) % 3];
      around.clear();
      surface_.triangles_at(tail, around);
      for (const Triangle64& other : around) {
        const bool opposite = (other[0] == head && other[1] == tail) ||
                              (other[1] == head && other[2] == tail) ||
                              (other[2] == head && other[0] == tail);
        if (opposite && seen.insert(other).second) next.push_back(other);
      }
    }
  }
  for (const Triangle64& t : seen) {
    const Vec3 a = surface_.position(t[0]);
    facts_.area -= 0.5 * norm(cross(surface_.position(t[1]) - a, surface_.position(t[2]) - a));
  }
  result_.removed.insert(result_.removed.end(), seen.begin(), seen.end());
}

/// Vertices of removed triangles that no other triangle uses. The surface still has them all.
void HoleStage::find_freed() {
  std::vector<std::uint64_t> vertices;
  for (const Triangle64& t : result_.removed) vertices.insert(vertices.end(), t.begin(), t.end());
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Triangle64> around;
  for (const std::uint64_t vertex : vertices) {
    around.clear();
    surface_.triangles_at(vertex, around);
    const bool all = std::all_of(around.begin(), around.end(), [&](const Triangle64& t) {
      return std::binary_search(result_.removed.begin(), result_.removed.end(), t);
    });
    if (all) result_.freed.push_back(vertex);
  }
}

void HoleStage::trace() {
  holes_ =
      plan_holes(fans_, std::move(boundary_.vertices), pieces_of(boundary_), context_.job.fill);
}

void HoleStage::cut_into_batches() {
  std::uint64_t work = 0;
  for (std::size_t i = 0; i < holes_.groups.size(); ++i) {
    const std::uint64_t edges = edges_of_group(i);
    if (batches_.empty() || batches_.back().count == kBatchLoops ||
        work + edges * edges > kBatchWork) {
      batches_.push_back({i, 0});
      work = 0;
    }
    ++batches_.back().count;
    work += edges * edges;
  }
}

std::uint64_t HoleStage::edges_of_group(std::size_t group) const {
  std::uint64_t edges = 0;
  for (const std::uint32_t l : holes_.loops_of(holes_.groups[group])) {
    edges += holes_.loops[l].vertices.size();
  }
  return edges;
}

/// Half of what is left, but no more than of what is spent where no boundary is in the way. Which
/// chunks are kept decides how often they are read, never what comes of them.
std::size_t HoleStage::bytes_for_chunks() const {
  const std::uint64_t budget = context_.job.partition.memory_bytes;
  const std::uint64_t left = budget - std::min(budget, resident_bytes());
  return std::min<std::size_t>(plan_.chunks_in_flight_bytes, left) / 2;
}

/// What the boundary takes is known by now: the prediction rises by it, chunks get what it leaves.
void HoleStage::plan_for_holes() {
  std::vector<std::uint8_t> is_seen(partition_.octree.chunks().size(), 0);
  for (const OpenFan& fan : fans_) is_seen[partition_.chunk_of(fan.vertex)] = 1;
  std::uint64_t chunk = 0, chunks = 0, batch = 0;
  for (ChunkId c = 0; c < is_seen.size(); ++c) {
    if (is_seen[c] == 0 || batches_.empty()) continue;
    chunk = std::max<std::uint64_t>(chunk, surface_.chunk_bytes(c));
    chunks += surface_.chunk_bytes(c);
  }
  for (ChunkId b = 0; b < batches_.size(); ++b) {
    batch = std::max<std::uint64_t>(batch, work_of(b).memory_bytes);
  }
  const HoleLoad load{fans_.size(), holes_.loops.size(), chunk, batch, chunks};
  require_memory_for_holes(context_, partition_, load);
  std::uint64_t& predicted = context_.report.predicted.peak_memory_bytes;
  predicted = std::max(predicted, predicted_hole_bytes(context_, partition_, load));
  surface_.limit_memory(bytes_for_chunks());
}

ChunkWork HoleStage::work_of(ChunkId batch) const {
  std::uint64_t work = 0, most = 0;
  for (std::size_t i = 0; i < batches_[batch].count; ++i) {
    const std::uint64_t edges = edges_of_group(batches_[batch].first + i);
    work += edges * edges;
    most = std::max(most, edges);
  }
  return {batch, bytes_to_fill(most), work, 0};
}

void HoleStage::fill(StageClock& clock) {
  std::vector<ChunkWork> tasks;
  for (ChunkId batch = 0; batch < batches_.size(); ++batch) tasks.push_back(work_of(batch));
  share_chunks(context_, clock, kHoleStage, std::move(tasks), bytes_for_chunks(),
               [&](ChunkId batch) { fill_batch(batch); });
}

void HoleStage::fill_batch(ChunkId number) {
  const Batch& batch = batches_[number];
  PatchBatch patches;
  for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
    context_.stop.check();
    for (LoopPatch& patch : fill_group(surface_, holes_, holes_.groups[i], context_.job.fill)) {
      const double area = area_of(surface_, patch);
      append_patch(std::move(patch), area, patches);
    }
  }
  commit_patch_batch(context_.store, number, patches);
}

void HoleStage::collect() {
  result_.holes = holes_.all_facts();
  holes_.reasons = {};
  for (ChunkId batch = 0; batch < batches_.size(); ++batch) {
    PatchBatch patches = load_patch_facts(context_.store, batch);
    std::uint64_t vertices = 0, triangles = 0;
    for (std::size_t i = 0; i < patches.facts.size(); ++i) {
      HoleFacts& facts = patches.facts[i];  // ids are ranks of loops, from 1
      vertices += facts.points_added;
      triangles += facts.triangles_added;
      patch_area_ += patches.areas[i];
      result_.holes[static_cast<std::size_t>(facts.id - 1)] = std::move(facts);
    }
    result_.new_vertices.push_back(vertices);
    result_.new_triangles.push_back(triangles);
  }
  for (std::size_t l = 0; l < holes_.loops.size(); ++l) {
    std::vector<std::uint32_t>& chunks = result_.holes[l].chunks;
    for (const std::uint64_t vertex : holes_.loops[l].vertices) {
      chunks.push_back(partition_.chunk_of(vertex));
    }
    std::sort(chunks.begin(), chunks.end());
    chunks.erase(std::unique(chunks.begin(), chunks.end()), chunks.end());
    chunks.shrink_to_fit();
  }
}

/// Doubles what is still pinched after the fill.
void HoleStage::split() {
  if (boundary_.pinched.empty()) return;
  struct AtVertex {
    std::uint64_t vertex;
    Triangle64 triangle;
  };
  std::vector<AtVertex> patched;
  std::uint64_t base = 0;
  for (ChunkId batch = 0; batch < batches_.size(); ++batch) {
    const PatchBatch patches = load_patch_batch(context_.store, batch);
    for (Triangle64 t : patches.triangles) {
      for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? base : 0;
      for (const std::uint64_t vertex : t) {
        if (std::binary_search(boundary_.pinched.begin(), boundary_.pinched.end(), vertex)) {
          patched.push_back({vertex, t});
        }
      }
    }
    base += patches.positions.size();
  }
  std::stable_sort(patched.begin(), patched.end(),
                   [](const AtVertex& a, const AtVertex& b) { return a.vertex < b.vertex; });
  std::vector<Triangle64> here;
  auto at = patched.begin();
  for (const std::uint64_t vertex : boundary_.pinched) {
    here.clear();
    for (; at != patched.end() && at->vertex == vertex; ++at) here.push_back(at->triangle);
    split_at(vertex, here);
  }
  std::sort(result_.splits.begin(), result_.splits.end());
}

void HoleStage::split_at(std::uint64_t vertex, std::span<const Triangle64> patch_triangles) {
  std::vector<Triangle64> around;
  surface_.triangles_at(vertex, around);
  around.insert(around.end(), patch_triangles.begin(), patch_triangles.end());
  const std::vector<std::uint32_t> group = fan_groups(around, vertex);
  const std::uint64_t first_copy = result_.copies.size();
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group[i] == 0) continue;
    const std::uint64_t copy = first_copy + group[i] - 1;
    if (copy == result_.copies.size()) result_.copies.push_back(vertex);
    result_.splits.push_back({around[i], vertex, copy});
  }
}

/// Fans that are left. Where a patch fills the gap after a fan, it goes on with the next one.
/// `corners`: of filled loops, (arriving from, vertex, leaving to), sorted.
void HoleStage::close_fans(std::span<const Triangle64> corners) {
  const auto filled_after = [&](std::uint64_t previous, std::uint64_t vertex) {
    const auto at =
        std::lower_bound(corners.begin(), corners.end(), Triangle64{previous, vertex, 0});
    const bool found = at != corners.end() && (*at)[0] == previous && (*at)[1] == vertex;
    return found ? &*at : nullptr;
  };
  using Edge = std::array<std::uint64_t, 2>;
  std::vector<Edge> begun;  // (vertex, next) of fans after a filled gap
  begun.reserve(corners.size());
  for (const Triangle64& corner : corners) begun.push_back({corner[1], corner[2]});
  std::sort(begun.begin(), begun.end());
  const auto is_begun = [&](const OpenFan& fan) {
    return std::binary_search(begun.begin(), begun.end(), Edge{fan.vertex, fan.next});
  };
  std::vector<Triangle64> gone;  // (vertex, next, previous) of those fans
  gone.reserve(begun.size());
  for (const OpenFan& fan : fans_)
    if (is_begun(fan)) gone.push_back({fan.vertex, fan.next, fan.previous});
  std::sort(gone.begin(), gone.end());
  std::erase_if(fans_, is_begun);
  for (OpenFan& fan : fans_) {
    while (const Triangle64* corner = filled_after(fan.previous, fan.vertex)) {
      const Triangle64 wanted{fan.vertex, (*corner)[2], 0};
      const auto at = std::lower_bound(gone.begin(), gone.end(), wanted);
      fan.previous = gone.at(static_cast<std::size_t>(at - gone.begin()))[2];
    }
  }
}

/// The fans with doubled vertices under their own numbers.
std::vector<OpenFan> HoleStage::in_split_numbers(std::vector<OpenFan> fans) const {
  struct Renamed {
    Triangle64 end;  // (tail, head, one of the two)
    std::uint64_t number;
  };
  std::vector<Renamed> numbers;
  numbers.reserve(2 * result_.splits.size());
  constexpr std::uint64_t kCopies = std::uint64_t{1} << 62;
  for (const SplitCorner& split : result_.splits) {
    const Triangle64& t = split.triangle;
    const int k = t[0] == split.vertex ? 0 : t[1] == split.vertex ? 1 : 2;
    numbers.push_back({{t[k], t[(k + 1) % 3], split.vertex}, kCopies + split.copy});
    numbers.push_back({{t[(k + 2) % 3], t[k], split.vertex}, kCopies + split.copy});
  }
  if (numbers.empty()) return fans;
  std::sort(numbers.begin(), numbers.end(),
            [](const Renamed& a, const Renamed& b) { return a.end < b.end; });
  const auto renamed = [&](std::uint64_t tail, std::uint64_t head, std::uint64_t vertex) {
    const Triangle64 end{tail, head, vertex};
    const auto at =
        std::lower_bound(numbers.begin(), numbers.end(), end,
                         [](const Renamed& known, const Triangle64& e) { return known.end < e; });
    return at != numbers.end() && at->end == end ? at->number : vertex;
  };
  for (OpenFan& fan : fans) {
    fan = {renamed(fan.previous, fan.vertex, fan.previous),
           renamed(fan.vertex, fan.next, fan.vertex), renamed(fan.vertex, fan.next, fan.next),
           fan.component};
  }
  return fans;
}

void HoleStage::update_facts() {
  DisjointSets pieces(boundary_.pieces.size());
  std::uint64_t removed_pieces = 0;
  for (std::uint64_t p = 0; p < boundary_.pieces.size(); ++p) {
    removed_pieces += is_removed(p) ? 1 : 0;
  }
  std::vector<Triangle64> corners;
  for (std::size_t l = 0; l < holes_.loops.size(); ++l) {
    const HoleFacts& hole = result_.holes[l];
    if (!hole.filled) continue;
    const BoundaryLoop& loop = holes_.loops[l];
    for (const std::uint64_t piece : loop.components) {
      pieces.unite(static_cast<std::uint32_t>(loop.components.front()),
                   static_cast<std::uint32_t>(piece));
    }
    if (hole.joined_to > 0) {
      const BoundaryLoop& around = holes_.loops[static_cast<std::size_t>(hole.joined_to - 1)];
      pieces.unite(static_cast<std::uint32_t>(loop.components.front()),
                   static_cast<std::uint32_t>(around.components.front()));
    }
    const std::size_t n = loop.vertices.size();
    for (std::size_t i = 0; i < n; ++i) {
      // Against the loop: the direction of the fans.
      corners.push_back({loop.vertices[(i + 2) % n], loop.vertices[(i + 1) % n], loop.vertices[i]});
    }
    facts_.vertices += hole.points_added;
    facts_.triangles += hole.triangles_added;
  }
  holes_.loops = {};
  std::sort(corners.begin(), corners.end());
  close_fans(corners);
  corners = {};
  std::uint64_t roots = 0;
  for (std::uint32_t p = 0; p < boundary_.pieces.size(); ++p) roots += pieces.find(p) == p ? 1 : 0;
  facts_.components = roots - removed_pieces;
  facts_.vertices += result_.copies.size();
  facts_.vertices -= result_.freed.size();
  facts_.triangles -= result_.removed.size();
  facts_.nonmanifold_vertices = 0;
  facts_.area += patch_area_;
  facts_.boundary_edges = fans_.size();
  facts_.boundary_loops = count_loops(in_split_numbers(std::move(fans_)));
  derive_facts(facts_);
}

}  // namespace

FilledHoles fill_holes(JobContext& context, const Partition& partition,
                       const std::vector<double>& radii, StitchedBoundary boundary,
                       MeshFacts& facts) {
  release_freed_memory();  // what the chunks' parts of the boundary were
  HoleStage stage(context, partition, radii, std::move(boundary), facts);
  return stage.run(hole_key(context, partition, radii));
}

std::vector<HoleFacts> list_loops(const StitchedBoundary& boundary, const FillOptions& options) {
  std::vector<OpenFan> fans;
  for (const OpenFan& fan : boundary.fans) {
    if (boundary.pieces[fan.component].triangles >= options.min_triangles) fans.push_back(fan);
  }
  return plan_holes(std::move(fans), boundary.vertices, pieces_of(boundary), options).all_facts();
}

const SplitCorner* find_split(const FilledHoles& holes, const Triangle64& triangle,
                              std::uint64_t vertex) {
  const auto at =
      std::lower_bound(holes.splits.begin(), holes.splits.end(), SplitCorner{triangle, vertex, 0});
  const bool found = at != holes.splits.end() && at->triangle == triangle && at->vertex == vertex;
  return found ? &*at : nullptr;
}

}  // namespace orbweave
