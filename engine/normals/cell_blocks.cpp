#include "engine/normals/cell_blocks.h"

namespace orbweave {
namespace {

/// Binary logarithm of how much wider the blocks of a level are than those before.
constexpr int kWider = 3;
/// Of the widest blocks: the cells of a ray lie in a few of them.
constexpr int kWidest = 60;

LatticePlace block_of(const LatticePlace& cell, int side_log) {
  return {cell[0] >> side_log, cell[1] >> side_log, cell[2] >> side_log};
}

}  // namespace

std::size_t LatticePlaceHash::operator()(const LatticePlace& place) const noexcept {
  std::uint64_t hash = 0;
  for (const std::int64_t number : place) {
    hash = (hash ^ static_cast<std::uint64_t>(number)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return static_cast<std::size_t>(hash);
}

CellBlocks::CellBlocks(std::span<const LatticePlace> cells) {
  if (cells.empty()) return;
  for (int side_log = kWider; side_log < kWidest; side_log += kWider) {
    auto& blocks = levels_.emplace_back();
    if (levels_.size() == 1)
      for (const LatticePlace& cell : cells) blocks.insert(block_of(cell, kWider));
    else
      for (const LatticePlace& block : levels_[levels_.size() - 2])
        blocks.insert(block_of(block, kWider));
    if (blocks.size() == 1 && blocks.contains(LatticePlace{})) break;
  }
}

/// Beyond the levels, all cells that are not empty lie in the first block along each axis.
bool CellBlocks::is_empty(const LatticePlace& cell, int side_log) const {
  const auto level = static_cast<std::size_t>(side_log / kWider - 1);
  const LatticePlace block = block_of(cell, side_log);
  return level < levels_.size() ? !levels_[level].contains(block) : block != LatticePlace{};
}

int CellBlocks::empty_around(const LatticePlace& cell) const {
  int side_log = 0;
  while (side_log + kWider <= kWidest && is_empty(cell, side_log + kWider)) side_log += kWider;
  return side_log;
}

}  // namespace orbweave
