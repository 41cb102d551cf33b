// Numbers that vertices of a mesh have of their points, and that viewers color by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/point_cloud.h"

namespace orbweave {

/// A number of each vertex, among the attributes of a mesh.
struct VertexValue {
  std::string name;  ///< in tiles and viewers
  std::size_t offset = 0;
  ScalarType type = ScalarType::kFloat32;
};

/// "vertex_confidence" (of "confidence", which a scan has), "quality_spacing", "quality_noise",
/// "quality_moved" (OutputOptions::vertex_quality) and "undersampled", those of them that the
/// schema has, in this order. The names are those of tiles; a schema may have either.
std::vector<VertexValue> vertex_values(const PointSchema& schema);

/// The value in a row of attributes; -1: not known, as of vertices that fill a hole.
float value_at(const VertexValue& value, const std::byte* row);

/// What of a value is told apart by color.
struct ShownRange {
  std::string name;
  double low = 0.0;
  double high = 0.0;
};

/// Goes over the values of all vertices. O(1) memory.
class ShownRanges {
 public:
  explicit ShownRanges(const PointSchema& schema);
  /// Rows of attributes of the schema.
  void add(std::span<const std::byte> rows);
  /// Of values that differ between vertices. Confidence from its least to its largest; lengths from
  /// 0 to three times their mean, at most to the largest, since few are much longer; undersampled
  /// from 0 to 1.
  std::vector<ShownRange> ranges() const;

 private:
  struct Sums {
    std::uint64_t count = 0;
    double sum = 0.0, least = 0.0, most = 0.0;
  };

  std::vector<VertexValue> values_;
  std::vector<Sums> sums_;
  std::size_t row_bytes_;
};

}  // namespace orbweave
