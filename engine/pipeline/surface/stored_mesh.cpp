#include "engine/pipeline/surface/stored_mesh.h"

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

void commit_chunk_mesh(ChunkStore& store, ChunkId chunk, const ChunkMesh& mesh) {
  const VoronoiFacts& voronoi = mesh.voronoi;
  const SideFacts& sides = mesh.sides;
  const std::vector<std::uint64_t> counts = {mesh.conflicts_lost,
                                             mesh.isolated_dropped,
                                             voronoi.undersampled_points,
                                             voronoi.uncertified_points,
                                             voronoi.grown_boxes,
                                             voronoi.contested_triangles,
                                             voronoi.seam_triangles,
                                             sides.looked,
                                             sides.steep,
                                             sides.smooth,
                                             sides.seams,
                                             sides.first_seam};
  const std::vector<Vec3> seam_place = {sides.place};
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
  mesh.voronoi = {counts.at(2), counts.at(3), counts.at(4), counts.at(5), counts.at(6)};
  mesh.sides = {.looked = counts.at(7),
                .steep = counts.at(8),
                .smooth = counts.at(9),
                .seams = counts.at(10),
                .first_seam = counts.at(11),
                .place = stored->read_all<Vec3>("side_seam").at(0)};
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
