// Columns of a mesh on their way to a file, each at its place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "io/meshes/mesh_columns.h"
#include "io/meshes/mesh_formats.h"
#include "io/system/placed_file.h"

namespace orbweave {

/// Writes rows to a file that is there. For one thread at a time.
class PlacedColumns {
 public:
  /// `places`: the first byte of each column in the file, those of vertices first. `name`: what the
  /// user knows the file as.
  PlacedColumns(const std::filesystem::path& file, const std::filesystem::path& name,
                const MeshHeader& header, MeshColumns columns, std::vector<std::uint64_t> places);

  void write_vertices(const PointCloud& batch);
  void write_triangles(std::span<const Triangle64> batch, std::span<const std::int32_t> hole);
  void write(std::uint64_t offset, std::span<const std::byte> bytes) { file_.write(offset, bytes); }
  /// All rows are there and on the device.
  void finish();

 private:
  PlacedFile file_;
  RowCounter counter_;
  MeshColumns columns_;
  std::vector<std::uint64_t> places_;
  std::uint64_t vertices_ = 0;
  std::uint64_t triangles_ = 0;
};

}  // namespace orbweave
