// A grid of square cells over a map: which cell a place lies in, and what the cell is called.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>

#include "io/vec3.h"

namespace orbweave {

/// Column and row of a cell. The cell (0, 0) has its lower left corner at x = 0, y = 0.
struct MapCell {
  std::int32_t x = 0;
  std::int32_t y = 0;
  friend auto operator<=>(const MapCell&, const MapCell&) = default;
};

/// Cells begin at the multiples of a size in x and in y, and reach up to the next multiple, which
/// belongs to the next cell. z has no cells.
class MapGrid {
 public:
  /// The sizes for which names are exact.
  static constexpr double kLeastSize = 1e-9;
  static constexpr double kLargestSize = 1e12;

  /// `size`: edge of a cell, world units, from kLeastSize to kLargestSize.
  explicit MapGrid(double size);

  /// Empty where the cell's column or row does not fit into 32 bit, or a coordinate is not finite.
  std::optional<MapCell> cell_of(Vec3 place) const;
  double size() const { return size_; }
  /// The x of a column, or the y of a row: the double that is nearest to that multiple of the size.
  double edge(std::int32_t index) const { return size_ * static_cast<double>(index); }
  /// Lower left corner, as in "448000_4511000" or "-0.5_12.25": exact decimals of the multiples, as
  /// many for all cells of a grid.
  std::string name(MapCell cell) const;

 private:
  double size_;
  std::int64_t digits_ = 0;  ///< of the size, as a decimal number without a point
  int decimals_ = 0;         ///< places of the point in it
};

}  // namespace orbweave
