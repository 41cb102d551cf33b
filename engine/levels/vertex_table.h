// The vertices of a mesh of any size, on disk, found by their numbers.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/point_cloud.h"
#include "io/system/running_checksum.h"
#include "io/system/spool_file.h"
#include "io/vertex_values.h"

namespace orbweave {

/// Rows of one width: position as three doubles, normal as three floats where there are normals,
/// the bytes of red, green and blue where there are all three, then floats of what vertices tell of
/// their points (io/vertex_values.h).
class VertexTable {
 public:
  /// `schema`: of the mesh that is read.
  VertexTable(const std::filesystem::path& directory, const PointSchema& schema);

  void append(const PointCloud& vertices);
  /// The rows of vertices whose numbers ascend, one after another. Thread-safe.
  std::vector<std::byte> rows(std::span<const std::uint64_t> numbers) const;

  /// What the rows hold: normals, colours, values by the names of tiles.
  const PointSchema& schema() const { return schema_; }
  std::size_t row_bytes() const { return row_bytes_; }
  std::uint64_t size() const { return vertices_; }
  std::vector<ShownRange> value_ranges() const { return ranges_.ranges(); }
  const Box& bounds() const { return bounds_; }  ///< of the finite positions
  std::uint64_t disk_bytes() const { return file_.bytes(); }
  std::uint64_t checksum() const { return checksum_.value(); }  ///< of all rows

  /// Rows as points with the table's schema.
  PointCloud points(std::span<const std::byte> rows) const;

 private:
  /// Bytes of an attribute in a row of the mesh.
  struct Kept {
    std::size_t offset = 0;
    std::size_t bytes = 0;
  };

  PointSchema schema_;
  std::vector<Kept> kept_;
  std::vector<VertexValue> values_;
  ShownRanges ranges_;
  std::size_t row_bytes_ = 0;
  std::uint64_t vertices_ = 0;
  Box bounds_;
  RunningChecksum checksum_;
  SpoolFile file_;
};

/// The position at the front of a row.
Vec3 position_of_row(const std::byte* row);

}  // namespace orbweave
