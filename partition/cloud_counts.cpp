#include "partition/cloud_counts.h"
#include "io/whole_loop.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "io/first_touch.h"
#include "partition/canonical_order.h"
#include "partition/count_grid.h"

namespace orbweave {
namespace {

constexpr std::size_t kGrain = 16384;

std::uint64_t code_of(CellIndex at) {
  return interleave(static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y),
                    static_cast<std::uint32_t>(at.z));
}

KeyList sorted_codes(std::span<const Vec3> positions, const CountLattice& lattice) {
  KeyList codes(positions.size());
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, codes.size(), kGrain),
      [&](const tbb::blocked_range<std::size_t>& range) {
        for (std::size_t i = range.begin(); i < range.end(); ++i)
          codes[i] = {code_of(lattice.at(positions[i])), static_cast<std::uint32_t>(i)};
      });
  radix_sort(codes);
  check_loops_are_whole();
  return codes;
}

/// The leaves of a tree of the cells, each once.
std::vector<KeyIndex> leaves_of(std::span<const KeyIndex> codes) {
  std::vector<KeyIndex> leaves;
  for (const KeyIndex& code : codes) {
    const std::uint64_t leaf = code.key >> (3 * kLeafLog2);
    if (leaves.empty() || leaves.back().key != leaf) leaves.push_back({leaf, 0});
  }
  return leaves;
}

}  // namespace

CloudCounts::CloudCounts(std::span<const Vec3> positions) : positions_(positions) {
  for (const Vec3& p : positions) bounds_.extend(p);
  if (!positions.empty()) count();
}

void CloudCounts::count() {
  const double root_side = root_cube(bounds_).side;
  lattice_ = CountLattice(std::ldexp(root_side, -kFinestLog2), bounds_, root_side);
  if (!(bounds_.largest_extent() > 0.0)) {
    cells_ = {{lattice_.at(bounds_.min), static_cast<std::uint32_t>(positions_.size())}};
    return;
  }
  const KeyList codes = sorted_codes(positions_, lattice_);
  const int levels = doublings_to_fit(
      leaves_of(codes), cells_limit_bytes(positions_.size(), CountGrid::kUsualLimitBytes),
      kFinestLog2 - kCoarsestLog2);
  lattice_ = CountLattice(std::ldexp(lattice_.cell, levels), bounds_, root_side);
  std::uint64_t last = 0;
  for (const KeyIndex& code : codes) {
    const std::uint64_t cell = code.key >> (3 * levels);
    if (cells_.empty() || cell != last) cells_.push_back({lattice_.at(positions_[code.index]), 0});
    last = cell;
    ++cells_.back().count;
  }
}

void CloudCounts::for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const {
  for (const Cell& cell : cells_) visit(lattice_.corner(cell.at), cell.count);
}

std::size_t CloudCounts::cells() const { return cells_.size(); }

void CloudCounts::for_each_at_once(
    const std::function<void(std::size_t, Vec3, std::uint64_t)>& visit) const {
  for_each_whole((cells_.size() + kGrain - 1) / kGrain, [&](std::size_t block) {
    for (std::size_t i = block * kGrain; i < std::min(cells_.size(), (block + 1) * kGrain); ++i)
      visit(i, lattice_.corner(cells_[i].at), cells_[i].count);
  });
}

void CloudCounts::for_each_place(
    const std::function<void(Vec3, double, std::uint64_t)>& visit) const {
  if (positions_.size() <= kEarlyPoints) {
    for (const Vec3& p : positions_) visit(p, 0.0, 1);
    return;
  }
  for_each([&](Vec3 corner, std::uint64_t count) { visit(corner, cell(), count); });
}

}  // namespace orbweave
