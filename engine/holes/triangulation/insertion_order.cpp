#include "engine/holes/triangulation/insertion_order.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace orbweave {
namespace {

constexpr int kBits = 16;  // of the Hilbert curve's grid, per axis

/// Position along the Hilbert curve of a cell of the 2^kBits x 2^kBits grid.
std::uint32_t hilbert(std::uint32_t x, std::uint32_t y) {
  std::uint32_t position = 0;
  for (int bit = kBits - 1; bit >= 0; --bit) {
    const std::uint32_t right = (x >> bit) & 1;
    const std::uint32_t upper = (y >> bit) & 1;
    position = 4 * position + ((3 * right) ^ upper);
    if (upper == 1) continue;
    // The lower quadrants hold the curve mirrored.
    if (right == 1) {
      x = ~x;
      y = ~y;
    }
    std::swap(x, y);
  }
  return position;
}

std::uint64_t mixed(std::uint64_t x) {
  x = (x + 0x9e3779b97f4a7c15ULL) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 29)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 32);
}

struct Box {
  PlanePoint low, high;
};

Box box_of(std::span<const PlanePoint> points) {
  Box box{points.front(), points.front()};
  for (const PlanePoint& p : points) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y)};
  }
  return box;
}

}  // namespace

std::vector<std::uint32_t> insertion_order(std::span<const PlanePoint> points, std::uint32_t first,
                                           std::uint32_t last) {
  if (first >= last) return {};
  const Box box = box_of(points.subspan(first, last - first));
  const std::int64_t extent = std::max(box.high.x - box.low.x, box.high.y - box.low.y);
  const int shift = std::max(0, static_cast<int>(std::bit_width(std::uint64_t(extent))) - kBits);
  struct Entry {
    int round;
    std::uint32_t place, index;
  };
  std::vector<Entry> entries;
  entries.reserve(last - first);
  for (std::uint32_t i = first; i < last; ++i) {
    const auto x = static_cast<std::uint32_t>((points[i].x - box.low.x) >> shift);
    const auto y = static_cast<std::uint32_t>((points[i].y - box.low.y) >> shift);
    entries.push_back({-std::countr_zero(mixed(i)), hilbert(x, y), i});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.round, a.place, a.index) < std::tie(b.round, b.place, b.index);
  });
  std::vector<std::uint32_t> order;
  order.reserve(entries.size());
  for (const Entry& entry : entries) order.push_back(entry.index);
  return order;
}

}  // namespace orbweave
