#include "engine/pipeline/surface/stored_mesh.h"

#include <stdexcept>
#include <string>
#include <vector>

namespace orbweave {
namespace {

template <class T>
ArrayView view(const char* name, ScalarType type, std::uint32_t columns, const std::vector<T>& v,
               std::size_t values_per_item) {
  return {name, type, columns, v.size() * values_per_item / columns, v.data()};
}

}  // namespace

static_assert(sizeof(OpenFan) == 32 && sizeof(BoundaryVertex) == 56 && sizeof(ChunkPiece) == 80,
              "stored as rows of 64-bit words");

std::array<std::uint64_t, 12> doubt_counts(const VoronoiFacts& voronoi, const SideFacts& sides) {
  return {voronoi.undersampled_points,
          voronoi.uncertified_points,
          voronoi.grown_boxes,
          voronoi.contested_triangles,
          voronoi.seam_triangles,
          sides.looked,
          sides.steep,
          sides.smooth,
          sides.seams,
          sides.upward,
          sides.downward,
          sides.first_seam};
}

void take_doubt_counts(std::span<const std::uint64_t> counts, VoronoiFacts& voronoi,
                       SideFacts& sides) {
  if (counts.size() != 12) throw std::logic_error("a stored mesh with other counts");
  voronoi = {counts[0], counts[1], counts[2], counts[3], counts[4]};
  sides.looked = counts[5];
  sides.steep = counts[6];
  sides.smooth = counts[7];
  sides.seams = counts[8];
  sides.upward = counts[9];
  sides.downward = counts[10];
  sides.first_seam = counts[11];
}

void commit_chunk_mesh(ChunkStore& store, ChunkId chunk, const ChunkMesh& mesh) {
  std::vector<std::uint64_t> counts = {mesh.conflicts_lost, mesh.isolated_dropped};
  const auto doubts = doubt_counts(mesh.voronoi, mesh.sides);
  counts.insert(counts.end(), doubts.begin(), doubts.end());
  const std::vector<Vec3> seam_place = {mesh.sides.place};
  const std::vector<double> area = {mesh.area}, volume = {mesh.volume};
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
      view("volume", ScalarType::kFloat64, 1, volume, 1),
      view("side_seam", ScalarType::kFloat64, 3, seam_place, 3),
      view(kStoredUndersampled, ScalarType::kUint8, 1, mesh.undersampled, 1),
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
    mesh.undersampled = stored->read_all<std::uint8_t>(kStoredUndersampled);
  }
  mesh.fans = stored->read_all<std::uint8_t>("fans");
  mesh.boundary = stored->read_all<OpenFan>("boundary");
  mesh.boundary_vertices = stored->read_all<BoundaryVertex>("boundary_vertices");
  mesh.pieces = stored->read_all<ChunkPiece>("pieces");
  mesh.seam = stored->read_all<SeamNode>("seam");
  const auto counts = stored->read_all<std::uint64_t>("counts");
  mesh.conflicts_lost = counts.at(0);
  mesh.isolated_dropped = counts.at(1);
  take_doubt_counts(std::span(counts).subspan(2), mesh.voronoi, mesh.sides);
  mesh.sides.place = stored->read_all<Vec3>("side_seam").at(0);
  mesh.area = stored->read_all<double>("area").at(0);
  mesh.volume = stored->read_all<double>("volume").at(0);
  return mesh;
}

std::uint64_t stored_triangles(const ChunkStore& store, ChunkId chunk) {
  return store.open(kMeshStage, chunk)->rows(kStoredTriangles);
}

void drop_stitch_of_unfinished_mesh(ChunkStore& store, const Partition& partition) {
  if (!store.key(kStitchStage)) return;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    if (!store.has(kMeshStage, chunk)) return store.discard_stage(kStitchStage);
  }
}

}  // namespace orbweave
