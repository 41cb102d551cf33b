#include "engine/pipeline/surface/hole_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/holes/fill_hole.h"
#include "engine/holes/hole_pass.h"
#include "engine/holes/loops/hole_choice.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/budget/time_forecast.h"
#include "engine/pipeline/surface/check_stage.h"
#include "engine/pipeline/surface/filled_boundary.h"
#include "engine/pipeline/surface/mended_holes.h"
#include "engine/pipeline/surface/patch_batch.h"
#include "engine/pipeline/surface/pinched_vertices.h"
#include "engine/pipeline/surface/small_pieces.h"
#include "engine/pipeline/surface/stored_surface.h"
#include "io/system/memory_watch.h"

namespace orbweave {
namespace {

constexpr const char* kDocument = "batches.json";
/// A batch ends where it has that many loops, or that much work (edges squared).
constexpr std::size_t kBatchLoops = 320;
constexpr std::uint64_t kBatchWork = 100'000;
/// What filling one hole may hold: a dense system of the largest size and its factors.
constexpr std::size_t kHoleBytes = std::size_t{48} << 20;
/// A batch of holes of a few edges, patches and texts included.
constexpr std::size_t kBatchBytes = std::size_t{4} << 20;
/// Chunks of the surface may stay in this part of the budget (one over it) while loops are traced.
constexpr std::size_t kKeptPart = 32;
/// What loops and their plan take per fan of the boundary, while loops are traced.
constexpr std::uint64_t kPlanBytesPerFan = 400;

/// As many sites as the square of its edges are around a hole; its system has the square of that.
std::size_t bytes_to_fill(std::uint64_t edges) {
  const std::size_t sites =
      std::min<std::uint64_t>(edges, 100) * std::min<std::uint64_t>(edges, 100);
  return std::min(kHoleBytes, kBatchBytes + 3 * sizeof(double) * sites * sites);
}

/// What a hole of many edges holds while it is filled, its patch included.
std::size_t bytes_with_patch(std::uint64_t edges, const FillOptions& options) {
  constexpr std::size_t kBytesPerPoint = 500, kBytesPerEdge = 2000;
  return bytes_to_fill(edges) + kBytesPerEdge * edges +
         kBytesPerPoint * expected_new_points(edges, options.graded);
}

std::vector<Piece> pieces_of(const StitchedBoundary& boundary) {
  std::vector<Piece> pieces;
  pieces.reserve(boundary.pieces.size());
  for (const ChunkPiece& piece : boundary.pieces) pieces.push_back({piece.triangles, piece.box});
  return pieces;
}

std::uint64_t largest_piece(const StitchedBoundary& boundary) {
  std::uint64_t largest = 0;
  for (const ChunkPiece& piece : boundary.pieces) largest = std::max(largest, piece.triangles);
  return largest;
}

/// The fans of pieces that are kept.
std::vector<OpenFan> kept_fans(std::vector<OpenFan> fans,
                               std::span<const std::uint8_t> is_removed) {
  std::erase_if(fans, [&](const OpenFan& fan) { return is_removed[fan.component] != 0; });
  return fans;
}

/// The pieces that are too small.
std::vector<std::uint8_t> small_pieces(const StitchedBoundary& boundary,
                                       const FillOptions& options) {
  return small_pieces(boundary.pieces, least_triangles(options, largest_piece(boundary)));
}

/// Groups of loops that are filled and stored together.
struct Batch {
  std::size_t first = 0;  ///< of the groups
  std::size_t count = 0;
};

/// The loops to be filled, and what bounds them.
struct TracedHoles {
  HolePlan plan;
  std::vector<OpenFan> fans;  ///< of pieces that are kept
  std::vector<Batch> batches;
  std::vector<std::uint8_t> is_removed;  ///< per piece: too small, or a crumb
};

std::uint64_t edges_of_group(const HolePlan& plan, std::size_t group) {
  std::uint64_t edges = 0;
  for (const std::uint32_t l : plan.loops_of(plan.groups[group]))
    edges += plan.loops[l].vertices.size();
  return edges;
}

std::vector<Batch> cut_into_batches(const HolePlan& plan) {
  std::vector<Batch> batches;
  std::uint64_t work = 0;
  for (std::size_t i = 0; i < plan.groups.size(); ++i) {
    const std::uint64_t edges = edges_of_group(plan, i);
    if (batches.empty() || batches.back().count == kBatchLoops ||
        work + edges * edges > kBatchWork) {
      batches.push_back({i, 0});
      work = 0;
    }
    ++batches.back().count;
    work += edges * edges;
  }
  return batches;
}

/// Of the largest group of loops that are filled at once.
std::uint64_t most_edges(const TracedHoles& holes, const Batch& batch) {
  std::uint64_t most = 0;
  for (std::size_t i = 0; i < batch.count; ++i)
    most = std::max(most, edges_of_group(holes.plan, batch.first + i));
  return most;
}

std::uint64_t most_edges(const TracedHoles& holes) {
  std::uint64_t most = 0;
  for (const Batch& batch : holes.batches) most = std::max(most, most_edges(holes, batch));
  return most;
}

ChunkWork work_of(const TracedHoles& holes, ChunkId batch, const FillOptions& options) {
  std::uint64_t work = 0;
  for (std::size_t i = 0; i < holes.batches[batch].count; ++i) {
    const std::uint64_t edges = edges_of_group(holes.plan, holes.batches[batch].first + i);
    work += edges * edges;
  }
  const std::uint64_t most = most_edges(holes, holes.batches[batch]);
  return {batch, bytes_with_patch(most, options), work, 0};
}

/// Half of what is left beside what else is held, but no more than of what is spent where no
/// boundary is in the way. Which chunks are kept decides how often they are read, never what comes
/// of them.
std::size_t bytes_for_chunks(const ResolvedJob& job, const Partition& partition,
                             std::uint64_t beside = 0) {
  const MemoryPlan plan = job.memory_plan(partition.points(), partition.schema);
  const std::uint64_t budget = job.partition.memory_bytes;
  const std::uint64_t left = budget - std::min(budget, resident_bytes() + beside);
  return std::min<std::size_t>(plan.chunks_in_flight_bytes, left) / 2;
}

/// What the stage has to hold, once the boundary is traced.
HoleLoad load_of(const TracedHoles& holes, const Partition& partition, const StoredSurface& surface,
                 const FillOptions& options) {
  std::vector<std::uint8_t> is_seen(partition.octree.chunks().size(), 0);
  for (const OpenFan& fan : holes.fans) is_seen[partition.chunk_of(fan.vertex)] = 1;
  std::uint64_t chunk = 0, chunks = 0, batch = 0;
  const std::uint64_t patch = bytes_with_patch(most_edges(holes), options);
  for (ChunkId c = 0; c < is_seen.size(); ++c) {
    if (is_seen[c] == 0 || holes.batches.empty()) continue;
    chunk = std::max<std::uint64_t>(chunk, surface.chunk_bytes(c));
    chunks += surface.chunk_bytes(c);
  }
  for (ChunkId b = 0; b < holes.batches.size(); ++b)
    batch = std::max<std::uint64_t>(batch, bytes_to_fill(most_edges(holes, holes.batches[b])));
  return {holes.fans.size(), holes.plan.loops.size(), chunk, batch, chunks, 0, patch};
}

/// Asks for the vertices of the surface in their order: those of one chunk after another.
Box box_of(const Surface& surface, const LoopPatch& patch) {
  Box box;
  std::vector<std::uint64_t> known;
  for (const Triangle64& t : patch.triangles) {
    for (const std::uint64_t v : t) {
      if (v < kNewVertex)
        known.push_back(v);
      else
        box.extend(patch.positions[v - kNewVertex]);
    }
  }
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  std::vector<Vec3> places(known.size());
  surface.positions(known, places);
  for (const Vec3 place : places) box.extend(place);
  return box;
}

/// Where the patches of all batches lie.
std::vector<PatchPlace> places_of_patches(const TracedHoles& holes, const Partition& partition,
                                          StageRunner& runner) {
  std::vector<PatchPlace> places;
  for (ChunkId batch = 0; batch < holes.batches.size(); ++batch) {
    runner.stop.check();
    const PatchBatch patches = load_patch_facts(runner.store, batch);
    for (std::size_t i = 0; i < patches.facts.size(); ++i)
      if (!patches.boxes[i].empty())
        places.push_back({patches.facts[i].id, batch,
                          partition.chunk_of(patches.facts[i].first_vertex), patches.boxes[i],
                          patches.facts[i].triangles_added});
  }
  return places;
}

void fill_batch(const TracedHoles& holes, ChunkId number, const Surface& surface,
                StageRunner& runner) {
  const Batch& batch = holes.batches[number];
  PatchBatch patches;
  for (std::size_t i = batch.first; i < batch.first + batch.count; ++i) {
    runner.stop.check();
    for (LoopPatch& patch :
         fill_group(surface, holes.plan, holes.plan.groups[i], runner.job.fill, &runner.stop)) {
      const Box box = box_of(surface, patch);
      append_patch(std::move(patch), box, patches);
    }
  }
  commit_patch_batch(runner.store, number, patches);
}

void begin_holes(const SurfaceInputs& inputs, std::size_t batches, StageRunner& runner) {
  by_root(runner, [&] {
    begin_stage(runner, kHoleStage,
                hole_key(runner.job, stored_mesh_key(runner.job, runner.store, inputs)));
    runner.store.commit_document(kHoleStage, kDocument,
                                 nlohmann::json{{"batches", batches}}.dump() + "\n");
  });
}

void fill_batches(const TracedHoles& holes, const Partition& partition, const Surface& surface,
                  StageClock& clock, StageRunner& runner) {
  // Read before threads ask for it: one that waits for another to read it cannot help.
  if (!holes.batches.empty() && runner.communicator.size() == 1 &&
      !runner.store.has(kHoleStage, 0)) {
    const std::uint32_t first = holes.plan.loops_of(holes.plan.groups.front()).front();
    surface.position(holes.plan.loops[first].vertices.front());
  }
  std::vector<ChunkWork> tasks;
  for (ChunkId batch = 0; batch < holes.batches.size(); ++batch)
    tasks.push_back(work_of(holes, batch, runner.job.fill));
  share_chunks(
      runner, clock, kHoleStage, std::move(tasks), bytes_for_chunks(runner.job, partition),
      [&](ChunkId batch) { fill_batch(holes, batch, surface, runner); }, Durability::kFollows);
}

/// The chunks that a loop lies in, ascending.
std::vector<std::uint32_t> chunks_of(const BoundaryLoop& loop, const Partition& partition) {
  std::vector<std::uint32_t> chunks;
  for (const std::uint64_t vertex : loop.vertices) chunks.push_back(partition.chunk_of(vertex));
  std::sort(chunks.begin(), chunks.end());
  chunks.erase(std::unique(chunks.begin(), chunks.end()), chunks.end());
  chunks.shrink_to_fit();
  return chunks;
}

/// The triangles of these holes of a batch; `ids` ascending. `first_vertex`: the number of the
/// batch's first new vertex among those of all batches.
void add_triangles_of(const PatchBatch& patches, std::span<const std::int32_t> ids,
                      std::uint64_t first_vertex, std::vector<Triangle64>& triangles) {
  for (std::size_t i = 0; i < patches.triangles.size() && !ids.empty(); ++i) {
    if (!std::binary_search(ids.begin(), ids.end(), patches.hole[i])) continue;
    Triangle64 t = patches.triangles[i];
    for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? first_vertex : 0;
    triangles.push_back(t);
  }
}

/// Triangles of a batch that what is left of the boundary follows from.
void add_patches_to_totals(const HolePlan& plan, const PatchBatch& facts, const ChunkStore& store,
                           ChunkId batch, std::uint64_t first_vertex, PatchTotals& sum) {
  std::vector<std::int32_t> open, joining;
  for (const HoleFacts& hole : facts.facts) {
    if (!hole.filled) continue;
    const auto l = static_cast<std::size_t>(hole.id - plan.first_id);
    if (hole.open_edges > 0)
      open.push_back(hole.id);
    else if (hole.joined_to != 0)
      joining.push_back(hole.joined_to);
    else if (plan.loops[l].components.size() > 1)
      joining.push_back(hole.id);
  }
  if (open.empty() && joining.empty()) return;
  std::sort(open.begin(), open.end());
  std::sort(joining.begin(), joining.end());
  const PatchBatch patches = load_patch_batch(store, batch);
  add_triangles_of(patches, open, first_vertex, sum.open_triangles);
  add_triangles_of(patches, joining, first_vertex, sum.joining_triangles);
}

/// The triangles of the batch that mended closed objects.
void add_mended_to_totals(const ChunkStore& store, ChunkId batch, std::uint64_t first_vertex,
                          PatchTotals& sum) {
  for (Triangle64 t : load_patch_batch(store, batch).triangles) {
    for (std::uint64_t& vertex : t) vertex += vertex >= kNewVertex ? first_vertex : 0;
    sum.mended_triangles.push_back(t);
  }
}

/// Takes the facts of all loops to `filled`, as far as batches were stored. `batches`: how many
/// are; one more than were filled where closed objects were mended.
PatchTotals collect_patches(TracedHoles& holes, ChunkId batches, const Partition& partition,
                            StageRunner& runner, FilledHoles& filled) {
  PatchTotals sum;
  std::uint64_t first_vertex = 0;
  filled.holes = holes.plan.all_facts();
  holes.plan.reasons = {};
  for (ChunkId batch = 0; batch < batches; ++batch) {
    runner.stop.check();
    PatchBatch patches = load_patch_facts(runner.store, batch);
    if (batch == holes.batches.size())
      add_mended_to_totals(runner.store, batch, first_vertex, sum);
    else
      add_patches_to_totals(holes.plan, patches, runner.store, batch, first_vertex, sum);
    std::uint64_t vertices = 0, triangles = 0;
    for (std::size_t i = 0; i < patches.facts.size(); ++i) {
      HoleFacts& facts = patches.facts[i];  // ids are ranks of loops, from 1
      vertices += facts.points_added;
      triangles += facts.triangles_added;
      sum.area += facts.area;
      const auto l = static_cast<std::size_t>(facts.id - 1);
      if (l >= filled.holes.size()) filled.holes.resize(l + 1);  // a gap that mending made
      filled.holes[l] = std::move(facts);
    }
    first_vertex += vertices;
    filled.new_vertices.push_back(vertices);
    filled.new_triangles.push_back(triangles);
  }
  for (std::size_t l = 0; l < holes.plan.loops.size(); ++l)
    filled.holes[l].chunks = chunks_of(holes.plan.loops[l], partition);
  for (std::size_t l = holes.plan.loops.size(); l < filled.holes.size(); ++l)
    filled.holes[l].chunks = {partition.chunk_of(filled.holes[l].first_vertex)};
  return sum;
}

template <class T>
void add_sorted(const std::vector<T>& more, std::vector<T>& to) {
  to.insert(to.end(), more.begin(), more.end());
  std::sort(to.begin(), to.end());
}

/// Takes pieces (`is_removed`, per piece) from the surface and from the area of the mesh.
void remove_pieces(HoleInputs& inputs, std::span<const std::uint8_t> is_removed,
                   StoredSurface& surface, FilledHoles& filled) {
  filled.pieces_removed += std::count(is_removed.begin(), is_removed.end(), 1);
  const RemovedPieces removed =
      find_removed(inputs.boundary.pieces, is_removed, surface, inputs.facts.area);
  inputs.facts.area = removed.area_left;
  add_sorted(removed.triangles, filled.removed);
  add_sorted(removed.freed, filled.freed);
  surface.remove(filled.removed);
}

/// Takes flaps at rims from the surface and from the area of the mesh.
void remove_flaps(const RimFlaps& flaps, HoleInputs& inputs, StoredSurface& surface,
                  FilledHoles& filled) {
  if (flaps.triangles.empty()) return;
  inputs.facts.area -= flaps.area;
  filled.flaps = flaps.triangles.size();
  add_sorted(flaps.triangles, filled.removed);
  add_sorted(flaps.freed, filled.freed);
  surface.remove(filled.removed);
}

/// Traces the loops. `inputs` ends without fans and vertices of the boundary, and with the area of
/// the mesh without the pieces that are removed; `filled` gets these.
TracedHoles trace_holes(HoleInputs& inputs, StoredSurface& surface, StageRunner& runner,
                        FilledHoles& filled) {
  const StageClock clock(runner, Stage::kTrace, 0, "edges");
  // The next stage need not read the chunks of a small surface again.
  const std::size_t kept_bytes = runner.job.partition.memory_bytes / kKeptPart;
  const FillOptions& options = runner.job.fill;
  StitchedBoundary& boundary = inputs.boundary;
  TracedHoles holes;
  holes.is_removed = small_pieces(boundary, options);
  remove_pieces(inputs, holes.is_removed, surface, filled);
  holes.fans = kept_fans(std::move(boundary.fans), holes.is_removed);
  runner.progress.advance(holes.fans.size());
  // Flaps are looked for loop by loop, and a loop may lie in several chunks.
  surface.limit_memory(
      bytes_for_chunks(runner.job, inputs.surface.partition, kPlanBytesPerFan * holes.fans.size()));
  FlapsToTake to_take{surface, holes.fans};
  holes.plan = plan_holes(holes.fans, std::move(boundary.vertices), pieces_of(boundary), options,
                          &runner.stop, &to_take);
  remove_flaps(to_take.flaps, inputs, surface, filled);
  surface.limit_memory(kept_bytes);
  const std::vector<std::uint8_t>& crumbs = holes.plan.crumbs;
  if (std::find(crumbs.begin(), crumbs.end(), 1) != crumbs.end()) {
    surface.limit_memory(bytes_for_chunks(runner.job, inputs.surface.partition));
    remove_pieces(inputs, crumbs, surface, filled);
    surface.limit_memory(kept_bytes);
    for (std::size_t p = 0; p < crumbs.size(); ++p) holes.is_removed[p] |= crumbs[p];
    holes.fans = kept_fans(std::move(holes.fans), crumbs);
  }
  holes.batches = cut_into_batches(holes.plan);
  release_freed_memory(runner.job.partition.memory_bytes);
  return holes;
}

/// Mends closed objects; `filled`, the surface and the area of the mesh lose what was taken out.
Mended mend(HoleInputs& inputs, TracedHoles& holes, StoredSurface& surface, StageRunner& runner,
            FilledHoles& filled) {
  std::sort(holes.fans.begin(), holes.fans.end(), [](const OpenFan& a, const OpenFan& b) {
    return a.vertex != b.vertex ? a.vertex < b.vertex : a.previous < b.previous;
  });
  const MendInputs to_mend{inputs.surface, surface,
                           holes.plan,     static_cast<ChunkId>(holes.batches.size()),
                           holes.fans,     inputs.boundary.pinched};
  Mended mended = mend_holes(to_mend, runner);
  runner.communicator.barrier(runner.stop);  // patches change only when all have read them
  by_root(runner, [&] { store_mended(mended, to_mend, runner); });
  if (mended.empty()) return mended;
  inputs.facts.area -= mended.taken_area;
  filled.pieces_removed += mended.pieces_gone;
  add_sorted(mended.taken, filled.removed);
  add_sorted(mended.freed, filled.freed);
  surface.remove(filled.removed);
  return mended;
}

}  // namespace

HoleResult fill_holes(HoleInputs inputs, StageRunner& runner) {
  // What the chunks' parts of the boundary were.
  release_freed_memory(runner.job.partition.memory_bytes);
  const Partition& partition = inputs.surface.partition;
  StoredSurface surface(runner.store, partition, longest_edge(inputs.surface.radii.values),
                        bytes_for_chunks(runner.job, partition), true);
  HoleResult result;
  TracedHoles holes = trace_holes(inputs, surface, runner, result.filled);
  // What the boundary takes is known by now: the prediction rises by it, chunks get what it leaves.
  const HoleLoad load = load_of(holes, partition, surface, runner.job.fill);
  require_memory_for_holes(runner.job, partition, load);
  result.predicted_peak_bytes = predicted_hole_bytes(runner.job, partition, load);
  surface.limit_memory(bytes_for_chunks(runner.job, partition, load.patch_bytes));
  JobSize size = size_of_job(partition, inputs.surface.radii.values, runner.communicator.size());
  size.loops = holes.plan.loops.size();
  runner.progress.expect(expected_stages(runner.job, size));
  {
    StageClock clock(runner, Stage::kHoles, holes.batches.size(), "batches");
    begin_holes(inputs.surface, holes.batches.size(), runner);
    fill_batches(holes, partition, surface, clock, runner);
    clock.facts().chunks = holes.batches.size();
  }
  holes.plan.vertices = {};
  holes.plan.islands = {};
  holes.plan.shared = {};
  // What an attempt before settled would hide patches from the check.
  by_root(runner, [&] { runner.store.discard_stage(kSettledStage); });
  // What has been gathered for the check and what is read for it share the memory.
  const std::size_t memory_bytes = bytes_for_chunks(runner.job, partition);
  surface.limit_memory(memory_bytes / 2);
  const CheckResult check = check_crossings(
      {inputs.surface, surface, places_of_patches(holes, partition, runner), memory_bytes / 2},
      runner);
  const StageClock clock(runner, Stage::kSettle, holes.batches.size(), "batches");
  const auto batches = static_cast<ChunkId>(holes.batches.size());
  surface.limit_memory(bytes_for_chunks(runner.job, partition));
  by_root(runner, [&] { drop_crossing_patches(check.dropped, batches, runner); });
  const Mended mended = mend(inputs, holes, surface, runner, result.filled);
  const ChunkId stored = batches + (mended.empty() ? 0 : 1);
  surface.limit_memory(0);
  SplitVertices split = split_pinched(inputs.boundary.pinched, surface, runner.store, stored,
                                      bytes_for_chunks(runner.job, partition), runner.stop);
  result.filled.splits = std::move(split.splits);
  result.filled.copies = std::move(split.copies);
  release_freed_memory(runner.job.partition.memory_bytes);
  const PatchTotals patches = collect_patches(holes, stored, partition, runner, result.filled);
  result.facts =
      facts_after_fill(std::move(inputs.facts),
                       {std::move(holes.fans), inputs.boundary.pieces, holes.is_removed, mended},
                       std::move(holes.plan.loops), result.filled, patches);
  result.facts.crossing_pairs = check.crossing_pairs;
  result.facts.patch_crossing_pairs = check.patch_crossing_pairs;
  return result;
}

std::uint64_t count_crossings_unfilled(const SurfaceInputs& inputs, StageRunner& runner) {
  const std::size_t memory_bytes = bytes_for_chunks(runner.job, inputs.partition);
  const StoredSurface surface(runner.store, inputs.partition, longest_edge(inputs.radii.values),
                              memory_bytes / 2, false);
  return check_crossings({inputs, surface, {}, memory_bytes / 2}, runner)
      .crossing_pairs.value_or(0);
}

std::vector<HoleFacts> list_loops(const StitchedBoundary& boundary, const FillOptions& options,
                                  const StopToken& stop) {
  return plan_holes(kept_fans(boundary.fans, small_pieces(boundary, options)), boundary.vertices,
                    pieces_of(boundary), options, &stop)
      .all_facts();
}

}  // namespace orbweave
