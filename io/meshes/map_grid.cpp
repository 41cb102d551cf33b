#include "io/meshes/map_grid.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>

namespace orbweave {
namespace {

/// Products of a size's digits and an index have up to 27 digits.
__extension__ using Wide = __int128;

/// The shortest decimals that give the double again, such as "0.25".
std::string shortest_decimals(double size) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, size, std::chars_format::fixed);
  if (end.ec != std::errc()) throw std::logic_error("a cell's size has too many digits");
  return {text, end.ptr};
}

std::string decimal_text(Wide value, int decimals) {
  const auto places = static_cast<std::size_t>(decimals);
  std::string text;  // from its end
  for (Wide left = value < 0 ? -value : value; left > 0 || text.size() <= places; left /= 10)
    text.push_back(static_cast<char>('0' + static_cast<int>(left % 10)));
  if (places > 0) text.insert(places, 1, '.');
  if (value < 0) text.push_back('-');
  std::reverse(text.begin(), text.end());
  return text;
}

/// The index of the cell that holds a coordinate. The quotient is rounded, so the edges decide.
std::optional<std::int32_t> index_of(double coordinate, double size) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  double index = std::floor(coordinate / size);
  if (!(std::abs(index) < kMost)) return std::nullopt;
  if (index * size > coordinate) index -= 1.0;
  if ((index + 1.0) * size <= coordinate) index += 1.0;
  return static_cast<std::int32_t>(index);
}

}  // namespace

MapGrid::MapGrid(double size) : size_(size) {
  if (!(size >= kLeastSize && size <= kLargestSize))
    throw std::logic_error("a cell's size is out of range");
  std::string text = shortest_decimals(size);
  if (const std::size_t point = text.find('.'); point != std::string::npos) {
    decimals_ = static_cast<int>(text.size() - point - 1);
    text.erase(point, 1);
  }
  std::from_chars(text.data(), text.data() + text.size(), digits_);
}

std::optional<MapCell> MapGrid::cell_of(Vec3 place) const {
  const std::optional<std::int32_t> x = index_of(place.x, size_), y = index_of(place.y, size_);
  if (!x || !y) return std::nullopt;
  return MapCell{*x, *y};
}

std::string MapGrid::name(MapCell cell) const {
  return decimal_text(static_cast<Wide>(digits_) * cell.x, decimals_) + "_" +
         decimal_text(static_cast<Wide>(digits_) * cell.y, decimals_);
}

}  // namespace orbweave
