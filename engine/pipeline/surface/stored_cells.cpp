#include "engine/pipeline/surface/stored_cells.h"

#include "engine/pipeline/stage/stages.h"

namespace orbweave {

void commit_cells(ChunkStore& store, ChunkId chunk, const ChunkCells& cells) {
  const std::vector<std::uint64_t> counts = {
      cells.facts.undersampled_points, cells.facts.uncertified_points, cells.facts.grown_boxes};
  const auto triangles = [](const char* name, const std::vector<Triangle64>& list) {
    return ArrayView{name, ScalarType::kUint64, 3, list.size(), list.data()};
  };
  const ArrayView arrays[] = {
      triangles("inner", cells.inner),
      triangles("seam", cells.seam),
      {"undersampled", ScalarType::kUint8, 1, cells.undersampled.size(), cells.undersampled.data()},
      {"counts", ScalarType::kUint64, 1, counts.size(), counts.data()},
  };
  store.commit(kCellStage, chunk, arrays);
}

ChunkCells load_cells(const ChunkStore& store, ChunkId chunk) {
  const auto stored = store.open(kCellStage, chunk);
  ChunkCells cells;
  cells.inner = stored->read_all<Triangle64>("inner");
  cells.seam = stored->read_all<Triangle64>("seam");
  cells.undersampled = stored->read_all<std::uint8_t>("undersampled");
  const auto counts = stored->read_all<std::uint64_t>("counts");
  cells.facts.undersampled_points = counts.at(0);
  cells.facts.uncertified_points = counts.at(1);
  cells.facts.grown_boxes = counts.at(2);
  return cells;
}

std::vector<Triangle64> load_inner_triangles(const ChunkStore& store, ChunkId chunk) {
  return store.open(kCellStage, chunk)->read_all<Triangle64>("inner");
}

std::vector<Triangle64> load_seam_triangles(const ChunkStore& store, ChunkId chunk) {
  return store.open(kCellStage, chunk)->read_all<Triangle64>("seam");
}

}  // namespace orbweave
