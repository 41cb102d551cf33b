#include "engine/pipeline/surface/stitch_stage.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "engine/ball_pivoting/halo_width.h"
#include "engine/pipeline/budget/memory_forecast.h"
#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/stored_mesh.h"
#include "engine/pipeline/surface/used_vertices.h"
#include "io/job/setting.h"

namespace orbweave {
namespace {

std::string advice_on_radii(const ResolvedJob& job) {
  if (!job.reconstruct.ball_radii.empty())
    return "try " + setting(job, "reconstruct.ball_radii", "auto");
  return "where scan lines lie farther apart than the points on them, " +
         setting_name(job, "reconstruct.ball_radii") +
         " has to be more than half the distance between the lines";
}

[[noreturn]] void throw_empty(const ResolvedJob& job, const BallRadii& radii) {
  if (is_in_core(job.reconstruct.method))
    throw_bad_input("no triangle can be formed by " + method_name(job),
                    {.file = job.files.front(),
                     .expected = "points that lie densely on a surface",
                     .advice = "Try " + setting(job, "reconstruct.method", "ball_pivoting")});
  throw_bad_input(
      "no triangle can be formed: no ball touches three points without holding a "
      "fourth, on the side their normals point to",
      {.file = job.files.front(),
       .place = {},
       .found = radii.reason,
       .expected = "points on a surface, normals that agree with it, and ball radii of "
                   "about the point spacing",
       .advice = "Points on one line carry no surface; " + advice_on_radii(job)});
}

/// For every chunk, the last one whose triangles may use its vertices.
std::vector<ChunkId> last_users(const Partition& partition, double longest_edge) {
  std::vector<ChunkId> last;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    const std::vector<ChunkId> near = partition.octree.neighbors(chunk, longest_edge);
    last.push_back(near.empty() ? chunk : std::max(chunk, near.back()));
  }
  return last;
}

/// Rows of all chunks together.
struct BorderRows {
  std::uint64_t fans = 0;
  std::uint64_t vertices = 0;
  std::uint64_t pieces = 0;
};

BorderRows border_rows(const ChunkStore& store, std::size_t chunks, const StopToken& stop) {
  BorderRows rows;
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    stop.check();
    const auto stored = store.open(kMeshStage, chunk);
    rows.fans += stored->rows("boundary");
    rows.vertices += stored->rows("boundary_vertices");
    rows.pieces += stored->rows("pieces");
  }
  return rows;
}

/// At least as many as the whole mesh has: what ends at a chunk's border counts in both chunks.
std::uint64_t loops_of_parts(const ChunkStore& store, std::size_t chunks, const StopToken& stop) {
  std::uint64_t loops = 0;
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    stop.check();
    loops += count_loops(store.open(kMeshStage, chunk)->read_all<OpenFan>("boundary"));
  }
  return loops;
}

/// How many loops there are is known when they are all there, or by going through them in vain.
void require_memory(const SurfaceInputs& inputs, const ResolvedJob& job, const BorderRows& rows,
                    const ChunkStore& store, const StopToken& stop) {
  HoleLoad load;
  load.edges = rows.fans;
  load.pieces = rows.pieces;
  if (boundary_bytes(job, inputs.partition, load) <= job.partition.memory_bytes) return;
  load.loops = loops_of_parts(store, inputs.partition.octree.chunks().size(), stop);
  require_memory_for_boundary(job, inputs.partition, load);
}

void commit_stitched(StageRunner& runner, const Stitched& stitched) {
  const MeshFacts& facts = stitched.facts;
  const StitchedBoundary& boundary = stitched.boundary;
  std::vector<std::uint64_t> counts = {facts.vertices,          facts.triangles,
                                       facts.components,        facts.boundary_edges,
                                       facts.boundary_loops,    facts.nonmanifold_vertices,
                                       stitched.conflicts_lost, stitched.unused_points};
  const auto doubts = doubt_counts(stitched.voronoi, stitched.sides);
  counts.insert(counts.end(), doubts.begin(), doubts.end());
  const auto array = [](const char* name, std::uint32_t columns, const auto& v) {
    return ArrayView{name, ScalarType::kUint64, columns, v.size(), v.data()};
  };
  const ArrayView arrays[] = {
      array("counts", 1, counts),
      {"area", ScalarType::kFloat64, 1, 1, &facts.area},
      {"volume", ScalarType::kFloat64, 1, 1, &facts.scanned_volume},
      {"side_seam", ScalarType::kFloat64, 3, 1, &stitched.sides.place},
      array("triangles", 1, stitched.triangles),
      {"used", ScalarType::kUint32, 1, stitched.used.size(), stitched.used.data()},
      array("fans", 4, boundary.fans),
      array("vertices", 7, boundary.vertices),
      array("pieces", 10, boundary.pieces),
      array("pinched", 1, boundary.pinched),
  };
  runner.store.commit(kStitchStage, 0, arrays, false);
  show_commits(runner);
}

/// It may have been stitched under a larger budget.
void require_memory_for_stored(const ResolvedJob& job, const Partition& partition,
                               const StoredResult& stored, std::span<const std::uint64_t> counts) {
  HoleLoad load;
  load.edges = stored.rows("fans");
  load.loops = counts[4];
  load.pieces = stored.rows("pieces");
  require_memory_for_boundary(job, partition, load);
}

Stitched load_stitched(const ResolvedJob& job, const Partition& partition,
                       const ChunkStore& store) {
  const auto stored = store.open(kStitchStage, 0);
  const auto counts = stored->read_all<std::uint64_t>("counts");
  require_memory_for_stored(job, partition, *stored, counts);
  Stitched stitched;
  MeshFacts& facts = stitched.facts;
  facts.vertices = counts.at(0);
  facts.triangles = counts.at(1);
  facts.components = counts.at(2);
  facts.boundary_edges = counts.at(3);
  facts.boundary_loops = counts.at(4);
  facts.nonmanifold_vertices = counts.at(5);
  facts.pinches = counts.at(5);
  facts.area = stored->read_all<double>("area").at(0);
  facts.scanned_volume = stored->read_all<double>("volume").at(0);
  derive_facts(facts);
  stitched.conflicts_lost = counts.at(6);
  stitched.unused_points = counts.at(7);
  take_doubt_counts(std::span(counts).subspan(8), stitched.voronoi, stitched.sides);
  stitched.sides.place = stored->read_all<Vec3>("side_seam").at(0);
  stitched.triangles = stored->read_all<std::uint64_t>("triangles");
  stitched.used = stored->read_all<std::uint32_t>("used");
  stitched.boundary = {
      stored->read_all<OpenFan>("fans"), stored->read_all<BoundaryVertex>("vertices"),
      stored->read_all<ChunkPiece>("pieces"), stored->read_all<std::uint64_t>("pinched")};
  return stitched;
}

std::optional<Stitched> stored_under(const std::string& key, const SurfaceInputs& inputs,
                                     const ResolvedJob& job, const ChunkStore& store) {
  if (!store.has_key(kStitchStage, key) || !store.has(kStitchStage, 0)) return std::nullopt;
  return load_stitched(job, inputs.partition, store);
}

}  // namespace

Stitched stitch_chunks(const SurfaceInputs& inputs, const ResolvedJob& job, const ChunkStore& store,
                       const StopToken& stop, const std::function<void()>& advance) {
  const Partition& partition = inputs.partition;
  const std::size_t chunks = partition.octree.chunks().size();
  const BorderRows rows = border_rows(store, chunks, stop);
  require_memory(inputs, job, rows, store, stop);
  const std::vector<ChunkId> last = last_users(partition, longest_edge(inputs.radii.values));
  MeshSummary summary(job.fill.enabled, [&](std::uint64_t vertex) -> MeshSummary::Users {
    const ChunkId chunk = partition.chunk_of(vertex);
    return {last[chunk], partition.first_vertex[chunk + 1]};
  });
  summary.reserve(rows.fans, rows.vertices, rows.pieces);
  Stitched stitched;
  for (ChunkId chunk = 0; chunk < chunks; ++chunk) {
    stop.check();
    const ChunkMesh mesh = load_chunk_mesh(store, chunk, true);
    stitched.triangles.push_back(stored_triangles(store, chunk));
    summary.add(mesh, partition.first_vertex[chunk], stitched.triangles.back());
    append_used_counts(mesh.fans, stitched.used);
    advance();
  }
  summary.finish();
  stitched.facts = summary.facts();
  stitched.conflicts_lost = summary.conflicts_lost();
  stitched.unused_points = summary.unused_points();
  stitched.voronoi = summary.voronoi();
  stitched.sides = summary.sides();
  if (!job.fill.enabled) return stitched;
  stitched.boundary = summary.take_boundary();
  HoleLoad load;
  load.edges = rows.fans;
  load.loops = stitched.facts.boundary_loops;
  load.pieces = stitched.facts.components;
  require_memory_for_boundary(job, partition, load);
  return stitched;
}

std::optional<Stitched> stored_stitch(const SurfaceInputs& inputs, const ResolvedJob& job,
                                      const ChunkStore& store) {
  return stored_under(stitch_key(job, stored_mesh_key(job, store, inputs)), inputs, job, store);
}

Stitched stitch(const SurfaceInputs& inputs, StageRunner& runner) {
  const std::size_t chunks = inputs.partition.octree.chunks().size();
  StageClock clock(runner, Stage::kStitch, chunks, "chunks");
  std::optional<Stitched> stitched;
  by_root(runner, [&] {
    const std::string key =
        stitch_key(runner.job, stored_mesh_key(runner.job, runner.store, inputs));
    stitched = stored_under(key, inputs, runner.job, runner.store);
    if (stitched) {
      clock.facts().chunks_reused = chunks;
      runner.progress.advance(chunks);
      return;
    }
    stitched = stitch_chunks(inputs, runner.job, runner.store, runner.stop,
                             [&] { runner.progress.advance(1); });
    runner.store.begin_stage(kStitchStage, key);
    commit_stitched(runner, *stitched);
  });
  if (!stitched) stitched = load_stitched(runner.job, inputs.partition, runner.store);
  clock.facts().chunks = chunks;
  if (stitched->facts.triangles == 0) throw_empty(runner.job, inputs.radii);
  return std::move(*stitched);
}

}  // namespace orbweave
