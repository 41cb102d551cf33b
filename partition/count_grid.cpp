#include "partition/count_grid.h"

#include <openvdb/version.h>
// Of OpenVDB only the nodes are used, which are templates: its library takes as long to load as a
// small job takes. What reads leaves from files when they are first touched would need the library.
#undef OPENVDB_USE_DELAYED_LOADING
#include <openvdb/tree/InternalNode.h>
#include <openvdb/tree/LeafNode.h>
#include <openvdb/tree/RootNode.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "io/error.h"
#include "io/whole_loop.h"
#include "partition/canonical_order.h"
#include "partition/count_lattice.h"
#include "partition/radix_sort.h"
#include "partition/root_cube.h"

namespace orbweave {
namespace {

using Count = std::uint32_t;
// Nodes far smaller than OpenVDB's usual ones: a surface fills a quarter of a leaf of 4^3 cells,
// an eighth of one of 8^3, and lone points cost 5 KiB instead of 300.
using Leaf = openvdb::tree::LeafNode<Count, 2>;
using Lower = openvdb::tree::InternalNode<Leaf, 2>;
using Upper = openvdb::tree::InternalNode<Lower, 3>;
using Root = openvdb::tree::RootNode<Upper>;
using openvdb::Coord;

static_assert(Leaf::TOTAL == kLeafLog2 && Lower::TOTAL == kLowerLog2 && Upper::TOTAL == kUpperLog2);

using Lattice = CountLattice;

Coord coord_of(CellIndex at) { return Coord(at.x, at.y, at.z); }
CellIndex index_of(const Coord& at) { return {at.x(), at.y(), at.z()}; }

std::uint64_t morton_of(const Coord& at, int log2) {
  const auto along = [&](int axis) { return static_cast<std::uint32_t>(at[axis]) >> log2; };
  return interleave(along(0), along(1), along(2));
}

void add_to(Count& count, std::uint64_t by) {
  if (by > std::numeric_limits<Count>::max() - count)
    throw_resource("more than 4294967295 points lie in one cell of the count grid");
  count += static_cast<Count>(by);
}

/// The tree with its books of memory, and a direct-mapped cache of where leaves are: points in
/// random order would spend their time on the way down the tree.
class CountTree {
 public:
  std::size_t bytes() const { return tree_bytes(leaves_, lowers_, uppers_); }
  std::size_t leaves() const { return leaves_; }

  /// Visits the leaves in the order of their coordinates.
  template <class Visit>
  void for_each_leaf(const Visit& visit) const {
    for (auto upper = root_.cbeginChildOn(); upper; ++upper)
      for (auto lower = upper->cbeginChildOn(); lower; ++lower)
        for (auto leaf = lower->cbeginChildOn(); leaf; ++leaf) visit(*leaf);
  }

  /// Coordinates must not be negative.
  void raise(const Coord& at, std::uint64_t by) {
    const Place& place = find(at);
    const openvdb::Index offset = Leaf::coordToOffset(at);
    const bool is_new = place.counts[offset] == 0;
    add_to(place.counts[offset], by);
    if (is_new) place.leaf->setActiveState(offset, true);
  }

  /// Asks for the memory that a later raise() goes to; the second finds its way where the first
  /// was a while ago. Points in random order would wait for each.
  void fetch_place(const Coord& at) const { __builtin_prefetch(&places_[slot(key_of(at))]); }
  void fetch_count(const Coord& at) const {
    const std::uint64_t key = key_of(at);
    const Place& place = places_[slot(key)];
    if (place.key == key) __builtin_prefetch(place.counts + Leaf::coordToOffset(at), 1);
  }

  /// Takes leaves of places that hold none, which is sooner done than raising count by count.
  void take(std::span<std::unique_ptr<Leaf>> leaves) {
    leaves_ += leaves.size();
    for (std::unique_ptr<Leaf>& leaf : leaves) {
      lowers_ += root_.probeConstNode<Lower>(leaf->origin()) == nullptr;
      uppers_ += root_.probeConstNode<Upper>(leaf->origin()) == nullptr;
      root_.addLeaf(leaf.release());
    }
  }

  /// Gives the leaves away, one after the other as they are visited, and is empty then.
  template <class Visit>
  void dissolve(const Visit& visit) {
    std::vector<Leaf*> leaves;
    leaves.reserve(leaves_);
    root_.stealNodes(leaves);
    root_.clear();
    leaves_ = lowers_ = uppers_ = 0;
    std::fill(places_.begin(), places_.end(), Place());
    for (Leaf* stolen : leaves) {
      const std::unique_ptr<Leaf> leaf(stolen);
      visit(*leaf);
    }
  }

 private:
  struct Place {
    std::uint64_t key = ~std::uint64_t{0};
    Count* counts = nullptr;
    Leaf* leaf = nullptr;
  };
  static constexpr int kPlacesLog2 = 16;

  static std::uint64_t key_of(const Coord& at) {
    const auto along = [&](int axis) { return static_cast<std::uint64_t>(at[axis]) >> kLeafLog2; };
    return along(0) | along(1) << 21 | along(2) << 42;
  }
  static std::size_t slot(std::uint64_t key) {
    return key * 0x9e3779b97f4a7c15 >> (64 - kPlacesLog2);
  }

  const Place& find(const Coord& at) {
    const std::uint64_t key = key_of(at);
    Place& place = places_[slot(key)];
    if (place.key != key) {
      Leaf& leaf = touch(at);
      place = {key, leaf.buffer().data(), &leaf};
    }
    return place;
  }

  Leaf& touch(const Coord& at) {
    if (Leaf* leaf = root_.probeLeaf(at)) return *leaf;
    lowers_ += root_.probeConstNode<Lower>(at) == nullptr;
    uppers_ += root_.probeConstNode<Upper>(at) == nullptr;
    ++leaves_;
    return *root_.touchLeaf(at);
  }

  Root root_{0};
  std::size_t leaves_ = 0, lowers_ = 0, uppers_ = 0;
  std::vector<Place> places_ = std::vector<Place>(std::size_t{1} << kPlacesLog2);
};

}  // namespace

// As long as all points are equal there is no scale: they are only counted (`lone_points`). After
// that the first points are kept (`early`), and only then put into the tree: as soon as there are
// more than kEarlyPoints of both.
struct CountGrid::State {
  std::size_t limit_bytes = 0;
  double finest_cell = 0.0;  ///< a power of two; 0: as fine as memory allows
  std::uint64_t points = 0;
  Box bounds;
  std::uint64_t lone_points = 0;
  Vec3 lone_point;
  std::vector<Vec3> early;
  std::unique_ptr<CountTree> tree;
  Lattice lattice;
  double root_side = 0.0;

  bool too_large() const { return tree->bytes() > limit_bytes && spare_doublings() > 0; }
  /// Beyond these, cells would not nest in the root cube.
  int spare_doublings() const {
    return std::max(0, std::ilogb(root_side) - kCoarsestLog2 - std::ilogb(lattice.cell));
  }
  /// Side of the cells that the memory of the grid is not spent on making smaller.
  double finest() const { return std::max(std::ldexp(root_side, -kFinestLog2), finest_cell); }
  bool has_scale() const { return bounds.largest_extent() > 0.0; }

  void keep(std::span<const Vec3> positions);
  void build();
  void count(std::span<const Vec3> positions);
  std::unique_ptr<Leaf> leaf_of(std::span<const KeyIndex> kept) const;
  void fit_lattice();
  std::size_t insert(std::span<const Vec3> positions);
  void coarsen_to_limit();
  void rebuild(int levels);
  void count_cells(const Part& part);
};

/// Puts points aside until there are enough to choose the cell well.
void CountGrid::State::keep(std::span<const Vec3> positions) {
  if (!has_scale()) {
    lone_point = positions.front();
    lone_points += positions.size();
    return;
  }
  const std::size_t room = std::min(positions.size(), kEarlyPoints - early.size());
  early.insert(early.end(), positions.begin(), positions.begin() + room);
  positions = positions.subspan(room);
  if (points <= kEarlyPoints) return;
  build();
  count(positions);
}

/// Makes the tree of what was kept, with the finest cells that its memory allows.
void CountGrid::State::build() {
  root_side = root_cube(bounds).side;
  lattice = Lattice(finest(), bounds, root_side);
  tree = std::make_unique<CountTree>();
  if (lone_points > 0) early.push_back(lone_point);
  std::vector<KeyIndex> leaves(early.size());
  constexpr std::size_t kBlock = std::size_t{1} << 14;
  for_each_whole((early.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min(early.size(), (block + 1) * kBlock); ++i)
      leaves[i] = {morton_of(coord_of(lattice.at(early[i])), kLeafLog2),
                   static_cast<std::uint32_t>(i)};
  });
  radix_sort(leaves);
  const int levels =
      doublings_to_fit(leaves, cells_limit_bytes(points, limit_bytes), spare_doublings());
  lattice = Lattice(std::ldexp(lattice.cell, levels), bounds, root_side);
  // Cells nest, so that the points of a leaf of any cells follow one another.
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < leaves.size(); ++i)
    if (i == 0 || leaves[i].key >> (3 * levels) != leaves[i - 1].key >> (3 * levels))
      begins.push_back(i);
  begins.push_back(leaves.size());
  std::vector<std::unique_ptr<Leaf>> made(begins.size() - 1);
  constexpr std::size_t kLeavesAtOnce = 256;
  for_each_whole((made.size() + kLeavesAtOnce - 1) / kLeavesAtOnce, [&](std::size_t block) {
    for (std::size_t i = block * kLeavesAtOnce;
         i < std::min(made.size(), (block + 1) * kLeavesAtOnce); ++i)
      made[i] = leaf_of(std::span(leaves).subspan(begins[i], begins[i + 1] - begins[i]));
  });
  tree->take(made);
  early = {};
}

/// Counts kept points that lie in one leaf.
std::unique_ptr<Leaf> CountGrid::State::leaf_of(std::span<const KeyIndex> kept) const {
  auto leaf = std::make_unique<Leaf>(coord_of(lattice.at(early[kept.front().index])), 0, false);
  Count* const counts = leaf->buffer().data();
  for (const KeyIndex& point : kept) {
    const bool lone = lone_points > 0 && point.index + 1 == early.size();
    const openvdb::Index offset = Leaf::coordToOffset(coord_of(lattice.at(early[point.index])));
    add_to(counts[offset], lone ? lone_points : 1);
    leaf->setActiveState(offset, true);
  }
  return leaf;
}

/// Counts points, all of which are within the bounds.
void CountGrid::State::count(std::span<const Vec3> positions) {
  fit_lattice();
  while (!positions.empty()) {
    positions = positions.subspan(insert(positions));
    if (too_large()) coarsen_to_limit();
  }
}

/// Makes the lattice right for the bounds as they are now.
void CountGrid::State::fit_lattice() {
  root_side = root_cube(bounds).side;
  const int levels = std::max(0, std::ilogb(finest()) - std::ilogb(lattice.cell));
  const Vec3 anchor = Lattice::anchor_of(bounds, std::max(root_side, finest()));
  if (levels > 0 || lattice.anchor != anchor) rebuild(levels);
}

/// Counts points until all are counted or the tree has outgrown its memory; returns how many.
std::size_t CountGrid::State::insert(std::span<const Vec3> positions) {
  // Scanned points come in runs of one cell; only a run's end touches the tree.
  struct Run {
    Coord at;
    std::size_t end;
  };
  std::array<Run, 128> runs;
  constexpr std::size_t kPlaceAhead = 24, kCountAhead = 12;  // runs
  const Lattice cells = lattice;
  std::size_t done = 0, next = 0;
  while (next < positions.size()) {
    std::size_t count = 0;
    for (; next < positions.size(); ++next) {
      const Coord at = coord_of(cells.at(positions[next]));
      if (count == 0 || !(at == runs[count - 1].at)) {
        if (count == runs.size()) break;
        runs[count++].at = at;
      }
      runs[count - 1].end = next + 1;
    }
    for (std::size_t r = 0; r < std::min(count, kPlaceAhead); ++r) tree->fetch_place(runs[r].at);
    for (std::size_t r = 0; r < count; done = runs[r++].end) {
      if (r + kPlaceAhead < count) tree->fetch_place(runs[r + kPlaceAhead].at);
      if (r + kCountAhead < count) tree->fetch_count(runs[r + kCountAhead].at);
      tree->raise(runs[r].at, runs[r].end - done);
      if (too_large()) return runs[r].end;
    }
  }
  return positions.size();
}

/// Doubles the cell as often as it takes. How often is found from the leaves alone, so the tree
/// is rebuilt once and ends where doubling step by step would end.
void CountGrid::State::coarsen_to_limit() {
  std::vector<KeyIndex> leaves;
  leaves.reserve(tree->leaves());
  tree->for_each_leaf([&](const Leaf& leaf) {
    leaves.push_back({morton_of(leaf.origin(), kLeafLog2), 0});
  });
  radix_sort(leaves);
  rebuild(doublings_to_fit(leaves, limit_bytes, spare_doublings()));
}

/// Moves all counts to the lattice of the bounds as they are now, with cells 2^levels as wide.
/// Old leaves go as they are read, so that there is never twice the memory.
void CountGrid::State::rebuild(int levels) {
  const Lattice coarse(std::ldexp(lattice.cell, levels), bounds, root_side);
  const Vec3 offset = (lattice.anchor - coarse.anchor) * lattice.cells_per_unit;
  const std::array<std::int64_t, 3> moved = {static_cast<std::int64_t>(offset.x),
                                             static_cast<std::int64_t>(offset.y),
                                             static_cast<std::int64_t>(offset.z)};
  lattice = coarse;
  tree->dissolve([&](const Leaf& leaf) {
    for (auto value = leaf.cbeginValueOn(); value; ++value) {
      const Coord at = value.getCoord();
      tree->raise(Coord(static_cast<int>((at.x() + moved[0]) >> levels),
                        static_cast<int>((at.y() + moved[1]) >> levels),
                        static_cast<int>((at.z() + moved[2]) >> levels)),
                  value.getValue());
    }
  });
}

CountGrid::CountGrid(std::size_t limit_bytes, double finest_cell)
    : state_(std::make_unique<State>()) {
  state_->limit_bytes = limit_bytes;
  state_->finest_cell = finest_cell;
}
CountGrid::~CountGrid() = default;
CountGrid::CountGrid(CountGrid&&) noexcept = default;
CountGrid& CountGrid::operator=(CountGrid&&) noexcept = default;

void CountGrid::add(std::span<const Vec3> positions) {
  if (positions.empty()) return;
  for (const Vec3& p : positions) state_->bounds.extend(p);
  state_->points += positions.size();
  if (state_->tree == nullptr)
    state_->keep(positions);
  else
    state_->count(positions);
}

void CountGrid::settle(double root_side) {
  State& state = *state_;
  if (!state.has_scale()) return;
  if (state.tree == nullptr) state.build();
  const double finest = std::ldexp(root_side, -kMortonDepth);
  if (state.lattice.cell < finest)
    state.rebuild(std::ilogb(finest) - std::ilogb(state.lattice.cell));
  if (state.lattice.cell > std::ldexp(root_side, -kCoarsestLog2))
    throw std::logic_error("CountGrid::settle: the root cube is smaller than the cloud");
}

std::uint64_t CountGrid::points() const { return state_->points; }
const Box& CountGrid::bounds() const { return state_->bounds; }

std::size_t CountGrid::memory_bytes() const {
  return state_->early.capacity() * sizeof(Vec3) +
         (state_->tree != nullptr ? state_->tree->bytes() : 0);
}

double CountGrid::cell() const {
  State& state = *state_;
  if (state.points == 0) return 1.0;
  if (!state.has_scale())
    return std::max(std::ldexp(root_cube(state.bounds).side, -kFinestLog2), state.finest_cell);
  if (state.tree == nullptr) state.build();
  return state.lattice.cell;
}

void CountGrid::for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const {
  State& state = *state_;
  if (state.points == 0) return;
  if (!state.has_scale()) {
    const Lattice lattice(cell(), state.bounds, root_cube(state.bounds).side);
    return visit(lattice.corner(lattice.at(state.bounds.min)), state.points);
  }
  if (state.tree == nullptr) state.build();
  state.tree->for_each_leaf([&](const Leaf& leaf) {
    for (auto value = leaf.cbeginValueOn(); value; ++value)
      visit(state.lattice.corner(index_of(value.getCoord())), value.getValue());
  });
}

std::size_t CountGrid::cells() const {
  State& state = *state_;
  if (state.points == 0) return 0;
  if (!state.has_scale()) return 1;
  if (state.tree == nullptr) state.build();
  std::size_t cells = 0;
  state.tree->for_each_leaf([&](const Leaf& leaf) { cells += leaf.onVoxelCount(); });
  return cells;
}

void CountGrid::for_each_at_once(
    const std::function<void(std::size_t, Vec3, std::uint64_t)>& visit) const {
  const State& state = *state_;
  const std::size_t count = cells();
  if (count <= 1)
    return for_each([&](Vec3 corner, std::uint64_t points) { visit(0, corner, points); });
  struct First {
    const Leaf* leaf;
    std::size_t cell;
  };
  constexpr std::size_t kLeavesAtOnce = 512;
  std::vector<First> firsts;
  firsts.reserve(state.tree->leaves());
  std::size_t before = 0;
  state.tree->for_each_leaf([&](const Leaf& leaf) {
    firsts.push_back({&leaf, before});
    before += leaf.onVoxelCount();
  });
  for_each_whole((firsts.size() + kLeavesAtOnce - 1) / kLeavesAtOnce, [&](std::size_t block) {
    const std::size_t end = std::min(firsts.size(), (block + 1) * kLeavesAtOnce);
    for (std::size_t i = block * kLeavesAtOnce; i < end; ++i) {
      std::size_t cell = firsts[i].cell;
      for (auto value = firsts[i].leaf->cbeginValueOn(); value; ++value)
        visit(cell++, state.lattice.corner(index_of(value.getCoord())), value.getValue());
    }
  });
}

void CountGrid::for_each_place(
    const std::function<void(Vec3, double, std::uint64_t)>& visit) const {
  const State& state = *state_;
  if (state.tree != nullptr)
    return for_each([&](Vec3 corner, std::uint64_t count) { visit(corner, cell(), count); });
  for (const Vec3& p : state.early) visit(p, 0.0, 1);
  if (state.lone_points > 0) visit(state.lone_point, 0.0, state.lone_points);
}

CountGrid::Part CountGrid::part() const {
  const State& state = *state_;
  Part part;
  part.bounds = state.bounds;
  if (state.tree == nullptr) {
    part.corners = state.early;
    part.counts.assign(part.corners.size(), 1);
    if (state.lone_points > 0) {
      part.corners.push_back(state.lone_point);
      part.counts.push_back(state.lone_points);
    }
    return part;
  }
  part.cell = cell();
  for_each([&](Vec3 corner, std::uint64_t count) {
    part.corners.push_back(corner);
    part.counts.push_back(count);
  });
  return part;
}

CountGrid CountGrid::of_parts(std::span<const Part> parts, std::size_t limit_bytes) {
  CountGrid grid(limit_bytes);
  State& state = *grid.state_;
  double coarsest = 0.0;
  std::uint64_t points = 0;
  Box bounds;
  for (const Part& part : parts) {
    bounds.extend(part.bounds);
    coarsest = std::max(coarsest, part.cell);
    for (const std::uint64_t count : part.counts) points += count;
  }
  if (points <= kEarlyPoints || !(bounds.largest_extent() > 0.0)) {
    for (const Part& part : parts) grid.add_points_of(part);
    return grid;
  }
  state.bounds = bounds;
  state.points = points;
  state.root_side = root_cube(bounds).side;
  // No part's cells are finer than those of the whole.
  coarsest = std::max(coarsest, std::ldexp(state.root_side, -kFinestLog2));
  state.lattice = Lattice(coarsest, bounds, state.root_side);
  state.tree = std::make_unique<CountTree>();
  for (const Part& part : parts) state.count_cells(part);
  return grid;
}

/// Few points, or all of them in one place.
void CountGrid::add_points_of(const Part& part) {
  for (std::size_t i = 0; i < part.corners.size(); ++i) {
    add({&part.corners[i], 1});
    if (!state_->has_scale()) {
      state_->points += part.counts[i] - 1;
      state_->lone_points += part.counts[i] - 1;
      continue;
    }
    for (std::uint64_t n = 1; n < part.counts[i]; ++n) add({&part.corners[i], 1});
  }
}

void CountGrid::State::count_cells(const Part& part) {
  // The middle of a cell lies in the same larger cell on any lattice.
  const double half = part.cell / 2.0;
  for (std::size_t i = 0; i < part.corners.size(); ++i) {
    tree->raise(coord_of(lattice.at(part.corners[i] + Vec3{half, half, half})), part.counts[i]);
    if (too_large()) coarsen_to_limit();
  }
}

}  // namespace orbweave
