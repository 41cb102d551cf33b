// Order of points along the Z-order curve (Morton, A Computer Oriented Geodetic Data Base, 1966),
// refined to a total order.
#include "partition/canonical_order.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstring>
#include <numeric>

#include "io/error.h"
#include "io/first_touch.h"
#include "io/whole_loop.h"
#include "partition/radix_sort.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kLastCell = (std::uint32_t{1} << kMortonDepth) - 1;
constexpr std::size_t kGrain = 16384;

/// Moves bit i to bit 3 i, for the lowest 21 bits.
constexpr std::uint64_t spread(std::uint64_t v) {
  v &= 0x1fffff;
  v = (v | v << 32) & 0x001f00000000ffff;
  v = (v | v << 16) & 0x001f0000ff0000ff;
  v = (v | v << 8) & 0x100f00f00f00f00f;
  v = (v | v << 4) & 0x10c30c30c30c30c3;
  v = (v | v << 2) & 0x1249249249249249;
  return v;
}

/// Undoes `spread`; other bits are ignored.
constexpr std::uint64_t gather(std::uint64_t v) {
  v &= 0x1249249249249249;
  v = (v | v >> 2) & 0x10c30c30c30c30c3;
  v = (v | v >> 4) & 0x100f00f00f00f00f;
  v = (v | v >> 8) & 0x001f0000ff0000ff;
  v = (v | v >> 16) & 0x001f00000000ffff;
  v = (v | v >> 32) & 0x1fffff;
  return v;
}

int compare_coordinates(Vec3 a, Vec3 b) {
  for (int axis = 0; axis < 3; ++axis) {
    if (a[axis] < b[axis]) return -1;
    if (b[axis] < a[axis]) return 1;
  }
  return 0;
}

/// By the bytes of two vectors, not by their values.
int compare_bytes(std::span<const Vec3> vectors, std::uint32_t a, std::uint32_t b) {
  const std::byte* const bytes = std::as_bytes(vectors).data();
  return std::memcmp(bytes + a * sizeof(Vec3), bytes + b * sizeof(Vec3), sizeof(Vec3));
}

/// Order of points of one Morton code; total up to bitwise equal points.
class TieOrder {
 public:
  explicit TieOrder(const PointColumns& columns) : cloud_(columns) {}

  bool operator()(const KeyIndex& a, const KeyIndex& b) const {
    int order = compare_coordinates(cloud_.positions[a.index], cloud_.positions[b.index]);
    if (order == 0 && !cloud_.normals.empty())
      order = compare_bytes(cloud_.normals, a.index, b.index);
    if (const std::size_t bytes = cloud_.attribute_bytes; order == 0 && bytes > 0)
      order = std::memcmp(cloud_.attributes.data() + a.index * bytes,
                          cloud_.attributes.data() + b.index * bytes, bytes);
    // Tells -0 from 0, so that which of them survives does not depend on the input's order.
    if (order == 0) order = compare_bytes(cloud_.positions, a.index, b.index);
    return order < 0;
  }

 private:
  const PointColumns cloud_;
};

KeyList coded_points(std::span<const Vec3> positions, const RootCube& root) {
  const MortonFrame frame(root);
  KeyList items(positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, items.size(), kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i)
                        items[i] = {frame.code(positions[i]), static_cast<std::uint32_t>(i)};
                    });
  return items;
}

/// Sorts the runs of equal code and returns the rows to keep, in order.
std::vector<std::uint32_t> resolve_ties(const PointColumns& cloud, KeyList& items) {
  std::vector<std::uint32_t> kept;
  kept.reserve(items.size());
  const TieOrder before(cloud);
  for (std::size_t begin = 0; begin < items.size();) {
    std::size_t end = begin + 1;
    while (end < items.size() && items[end].key == items[begin].key) ++end;
    if (end - begin > 1) std::sort(items.begin() + begin, items.begin() + end, before);
    kept.push_back(items[begin].index);
    for (std::size_t i = begin + 1; i < end; ++i)
      if (!(cloud.positions[items[i].index] == cloud.positions[kept.back()]))
        kept.push_back(items[i].index);
    begin = end;
  }
  return kept;
}

/// Replaces `rows` (of `width` elements each) by the selected ones.
template <class T>
void select_rows(std::vector<T>& rows, std::size_t width, const std::vector<std::uint32_t>& order) {
  if (rows.empty()) return;
  std::vector<T> selected;
  reserve_touched(selected, order.size() * width);
  selected.resize(order.size() * width);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, order.size(), kGrain),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i < range.end(); ++i)
                        std::copy_n(rows.begin() + order[i] * width, width,
                                    selected.begin() + i * width);
                    });
  rows = std::move(selected);
}

bool is_identity(const std::vector<std::uint32_t>& order, std::size_t size) {
  if (order.size() != size) return false;
  for (std::size_t i = 0; i < size; ++i)
    if (order[i] != i) return false;
  return true;
}

}  // namespace

MortonFrame::MortonFrame(const RootCube& root) : scale_(std::ldexp(1.0, kMortonDepth) / root.side) {
  for (int axis = 0; axis < 3; ++axis) {
    // Both forms of floor(p * scale) - origin * scale are exact: far from zero p and origin are
    // within a factor of two, so their difference has no rounding (Sterbenz); near zero
    // p * scale is small enough to be split into whole cells before the origin is taken off.
    // (p - origin) * scale would round a tiny negative p up into the cell of zero.
    const bool far = std::abs(root.origin[axis]) >= 2.0 * root.side;
    shift_[axis] = far ? root.origin[axis] : 0.0;
    low_[axis] = far ? 0.0 : root.origin[axis] * scale_;
  }
}

std::uint32_t MortonFrame::coordinate(double value, int axis) const {
  const double low = low_[axis];
  const double cell = std::clamp((value - shift_[axis]) * scale_, low, low + kLastCell);
  const auto whole = static_cast<std::int64_t>(cell);
  const std::int64_t floor = whole - (cell < static_cast<double>(whole) ? 1 : 0);
  return static_cast<std::uint32_t>(floor - static_cast<std::int64_t>(low));
}

std::uint64_t MortonFrame::code(Vec3 p) const {
  return interleave(coordinate(p.x, 0), coordinate(p.y, 1), coordinate(p.z, 2));
}

std::uint64_t interleave(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread(x) | spread(y) << 1 | spread(z) << 2;
}

std::uint32_t deinterleave(std::uint64_t code, int axis) {
  return static_cast<std::uint32_t>(gather(code >> axis));
}

std::uint64_t morton_code(Vec3 p, const RootCube& root) { return MortonFrame(root).code(p); }

PointColumns columns_of(const PointCloud& cloud) {
  return {cloud.positions, cloud.normals, cloud.attributes, cloud.schema.attribute_bytes()};
}

std::vector<std::uint32_t> canonical_rows(const PointColumns& columns, const RootCube& root) {
  const std::size_t points = columns.positions.size();
  if (points > UINT32_MAX)
    throw_resource("a chunk of " + std::to_string(points) + " points is too large to sort",
                   {.advice = "Set partition.chunk_points below 4294967296"});
  KeyList items = coded_points(columns.positions, root);
  radix_sort(items);
  check_loops_are_whole();
  return resolve_ties(columns, items);
}

std::uint64_t sort_canonically(PointCloud& cloud, const RootCube& root) {
  const std::vector<std::uint32_t> order = canonical_rows(columns_of(cloud), root);
  const std::uint64_t merged = cloud.size() - order.size();
  if (is_identity(order, cloud.size())) return 0;
  select_rows(cloud.positions, 1, order);
  select_rows(cloud.normals, 1, order);
  select_rows(cloud.attributes, cloud.schema.attribute_bytes(), order);
  return merged;
}

bool canonically_before(Vec3 a, Vec3 b, const RootCube& root) {
  const MortonFrame frame(root);
  const std::uint64_t code_a = frame.code(a);
  const std::uint64_t code_b = frame.code(b);
  return code_a != code_b ? code_a < code_b : compare_coordinates(a, b) < 0;
}

}  // namespace orbweave
