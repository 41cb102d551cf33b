#include "io/meshes/placed_columns.h"

#include <string>
#include <utility>

namespace orbweave {

PlacedColumns::PlacedColumns(const std::filesystem::path& file, const std::filesystem::path& name,
                             const MeshHeader& header, MeshColumns columns,
                             std::vector<std::uint64_t> places)
    : file_(file, name),
      counter_(header),
      columns_(std::move(columns)),
      places_(std::move(places)) {}

void PlacedColumns::write_vertices(const PointCloud& batch) {
  counter_.vertices(batch.size());
  for (std::size_t i = 0; i < columns_.of_vertices().size(); ++i) {
    const MeshColumn& column = columns_.of_vertices()[i];
    file_.write(places_[i] + vertices_ * column.row_bytes(), columns_.rows(column, batch));
  }
  vertices_ += batch.size();
}

void PlacedColumns::write_triangles(std::span<const Triangle64> batch,
                                    std::span<const std::int32_t> hole) {
  counter_.triangles(batch.size());
  const std::size_t first = columns_.of_vertices().size();
  for (std::size_t i = 0; i < columns_.of_triangles().size(); ++i) {
    const MeshColumn& column = columns_.of_triangles()[i];
    file_.write(places_[first + i] + triangles_ * column.row_bytes(),
                columns_.rows(column, batch, hole, triangles_));
  }
  triangles_ += batch.size();
}

void PlacedColumns::finish() {
  counter_.finish();
  file_.flush();
}

}  // namespace orbweave
