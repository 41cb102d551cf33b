#include "partition/count_lattice.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace orbweave {
namespace {

// Memory of the grid of a cloud that is kept as points at first.
constexpr std::size_t kSmallCloudBytesPerPoint = 100;
constexpr std::size_t kSmallCloudBytes = std::size_t{1} << 20;

}  // namespace

std::size_t cells_limit_bytes(std::uint64_t points, std::size_t limit_bytes) {
  if (points > kEarlyPoints) return limit_bytes;
  const std::size_t wanted = std::max(kSmallCloudBytes, points * kSmallCloudBytesPerPoint);
  return std::min(wanted, limit_bytes);
}

int doublings_to_fit(std::span<const KeyIndex> leaves, std::size_t limit_bytes, int most) {
  // distinct[k]: nodes of 2^k leaves a side, from the highest bit in which neighbours differ.
  std::array<std::size_t, kMortonDepth + kUpperLog2 + 1> distinct{};
  for (std::size_t i = 1; i < leaves.size(); ++i)
    if (const std::uint64_t differing = leaves[i].key ^ leaves[i - 1].key; differing != 0)
      ++distinct[(static_cast<std::size_t>(std::bit_width(differing)) - 1) / 3];
  for (std::size_t k = distinct.size() - 1; k-- > 0;) distinct[k] += distinct[k + 1];
  for (std::size_t& nodes : distinct) ++nodes;
  for (int levels = 0; levels < most; ++levels)
    if (tree_bytes(distinct[levels], distinct[levels + kLowerLog2 - kLeafLog2],
                   distinct[levels + kUpperLog2 - kLeafLog2]) <= limit_bytes)
      return levels;
  return most;
}

CountLattice::CountLattice(double cell_side, const Box& bounds, double root_side)
    : cell(cell_side), cells_per_unit(1.0 / cell_side) {
  const double side = std::max(root_side, cell_side);
  anchor = anchor_of(bounds, side);
  for (int axis = 0; axis < 3; ++axis) {
    // Both ways are exact, as in MortonFrame.
    const bool far = std::abs(anchor[axis]) >= 4.0 * side;
    shift[axis] = far ? anchor[axis] : 0.0;
    low[axis] = far ? 0.0 : anchor[axis] * cells_per_unit;
  }
}

Vec3 CountLattice::anchor_of(const Box& bounds, double side) {
  const auto down = [&](double value) { return std::floor(value / side) * side; };
  return {down(bounds.min.x), down(bounds.min.y), down(bounds.min.z)};
}

}  // namespace orbweave
