#include "engine/pipeline/reconstruct_stage.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/memory_forecast.h"
#include "engine/pipeline/stage_keys.h"
#include "engine/pipeline/stitch_stage.h"
#include "io/chunk_points.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

template <class T>
ArrayView view(const char* name, ScalarType type, std::uint32_t columns, const std::vector<T>& v,
               std::size_t values_per_item) {
  return {name, type, columns, v.size() * values_per_item / columns, v.data()};
}

/// Puts a neighbour's points in their place, from `at` on; returns where they end.
std::size_t put(const PointsInBox& from, std::uint64_t first_vertex, std::size_t at,
                ChunkPoints& to) {
  const auto place = static_cast<std::ptrdiff_t>(at);
  std::copy(from.points.positions.begin(), from.points.positions.end(),
            to.positions.begin() + place);
  std::copy(from.points.normals.begin(), from.points.normals.end(), to.normals.begin() + place);
  for (const std::uint32_t row : from.rows) to.global[at++] = first_vertex + row;
  return at;
}

/// The same of the chunk's own, read straight to it.
std::size_t put_own(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                    std::size_t at, ChunkPoints& to) {
  const std::size_t count = partition.points_in(chunk);
  load_oriented_points(store, chunk, partition.schema, std::span(to.positions).subspan(at, count),
                       std::span(to.normals).subspan(at, count));
  const auto first = to.global.begin() + static_cast<std::ptrdiff_t>(at);
  std::iota(first, first + static_cast<std::ptrdiff_t>(count), partition.first_vertex[chunk]);
  std::fill_n(to.owned.begin() + static_cast<std::ptrdiff_t>(at), count, std::uint8_t{1});
  to.owned_begin = static_cast<std::uint32_t>(at);
  to.owned_end = static_cast<std::uint32_t>(at + count);
  return at + count;
}

}  // namespace

static_assert(sizeof(OpenFan) == 32 && sizeof(BoundaryVertex) == 56 && sizeof(ChunkPiece) == 80,
              "stored as rows of 64-bit words");

void commit_chunk_mesh(ChunkStore& store, ChunkId chunk, const ChunkMesh& mesh) {
  const std::vector<std::uint64_t> counts = {mesh.conflicts_lost, mesh.isolated_dropped};
  const std::vector<double> area = {mesh.area};
  const ArrayView arrays[] = {
      view(kStoredTriangles, ScalarType::kUint32, 3, mesh.triangles, 3),
      view("fans", ScalarType::kUint8, 1, mesh.fans, 1),
      view(kStoredOuter, ScalarType::kUint64, 1, mesh.outer_vertices, 1),
      view("outer_positions", ScalarType::kFloat64, 3, mesh.outer_positions, 3),
      view("boundary", ScalarType::kUint64, 4, mesh.boundary, 4),
      view("boundary_vertices", ScalarType::kUint64, 7, mesh.boundary_vertices, 7),
      view("pieces", ScalarType::kUint64, 10, mesh.pieces, 10),
      view("seam", ScalarType::kUint64, 3, mesh.seam, 3),
      view("counts", ScalarType::kUint64, 1, counts, 1),
      view("area", ScalarType::kFloat64, 1, area, 1),
  };
  store.commit(kMeshStage, chunk, arrays);
}

ChunkMesh load_chunk_mesh(const ChunkStore& store, ChunkId chunk, bool summary_only) {
  const auto stored = store.open(kMeshStage, chunk);
  ChunkMesh mesh;
  if (!summary_only) {
    mesh.triangles = stored->read_all<Triangle>(kStoredTriangles);
    mesh.outer_vertices = stored->read_all<std::uint64_t>(kStoredOuter);
    mesh.outer_positions = stored->read_all<Vec3>("outer_positions");
  }
  mesh.fans = stored->read_all<std::uint8_t>("fans");
  mesh.boundary = stored->read_all<OpenFan>("boundary");
  mesh.boundary_vertices = stored->read_all<BoundaryVertex>("boundary_vertices");
  mesh.pieces = stored->read_all<ChunkPiece>("pieces");
  mesh.seam = stored->read_all<SeamNode>("seam");
  const auto counts = stored->read_all<std::uint64_t>("counts");
  mesh.conflicts_lost = counts.at(0);
  mesh.isolated_dropped = counts.at(1);
  mesh.area = stored->read_all<double>("area").at(0);
  return mesh;
}

std::uint64_t stored_triangles(const ChunkStore& store, ChunkId chunk) {
  return store.open(kMeshStage, chunk)->rows(kStoredTriangles);
}

ChunkPoints load_chunk_with_halo(const ChunkStore& store, const Partition& partition, ChunkId chunk,
                                 double halo) {
  const Chunk& self = partition.octree.chunks()[chunk];
  const Box reach = self.box.grown(halo);
  std::vector<ChunkId> sources = partition.octree.neighbors(chunk, halo);
  sources.push_back(chunk);
  // Chunks in Morton order, points in canonical order within: the whole is in canonical order.
  std::sort(sources.begin(), sources.end());
  std::vector<PointsInBox> parts;
  std::size_t count = partition.points_in(chunk);
  for (const ChunkId source : sources) {
    parts.push_back(source == chunk ? PointsInBox{}
                                    : load_points_in_box(store, source, partition.schema, reach));
    count += parts.back().rows.size();
  }
  ChunkPoints points;
  points.positions.resize(count);
  points.normals.resize(count);
  points.global.resize(count);
  points.owned.resize(count, 0);
  std::size_t at = 0;
  for (std::size_t i = 0; i < sources.size(); ++i) {
    at = sources[i] == chunk ? put_own(store, partition, chunk, at, points)
                             : put(parts[i], partition.first_vertex[sources[i]], at, points);
    parts[i] = {};
  }
  return points;
}

void reconstruct_chunks(JobContext& context, const Partition& partition,
                        const std::vector<double>& radii) {
  by_leader(context, [&] {
    begin_stage(context, kMeshStage, mesh_key(context, partition, radii));
    drop_stitch_of_unfinished_mesh(context, partition);
  });

  const auto& chunks = partition.octree.chunks();
  StageClock clock(context, "reconstruct", chunks.size(), "chunks");
  const double halo = halo_width(radii);
  const auto points_in_reach = points_with_halos(context.store, partition, halo);
  require_memory_for_largest(context, partition, points_in_reach, radii);
  std::vector<ChunkWork> tasks;
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const std::uint64_t points = points_in_reach[chunk];
    tasks.push_back(
        {chunk, points * MemoryCosts::kReconstructBytes, points, partition.points_in(chunk)});
  }
  const BallPivotingOptions options{radii, partition.octree.root().origin};
  const MemoryPlan plan =
      plan_memory(context.job.partition.memory_bytes, partition.points(), context.threads(),
                  context.job.partition.chunk_points, partition.schema);
  share_chunks(
      context, clock, kMeshStage, std::move(tasks), plan.chunks_in_flight_bytes,
      [&](ChunkId chunk) {
        const ChunkPoints points = load_chunk_with_halo(context.store, partition, chunk, halo);
        BallPivotingResult result =
            ball_pivoting(points.positions, points.normals, points.owned, options);
        commit_chunk_mesh(
            context.store, chunk,
            make_chunk_mesh(points, std::move(result), chunks[chunk].box, 2.0 * radii.back()));
      });
  clock.facts().points = partition.points();
}

}  // namespace orbweave
