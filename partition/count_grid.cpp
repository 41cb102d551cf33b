#include "partition/count_grid.h"

#include <openvdb/tree/Tree.h>
#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "io/error.h"
#include "partition/root_cube.h"

namespace orbweave {
namespace {

using Count = std::uint32_t;
// Inner nodes of 8^3 children rather than OpenVDB's 32^3 and 16^3: while few points lie far
// apart in a cell lattice that is still too fine, a point costs 10 KiB instead of 300.
using Tree = openvdb::tree::Tree4<Count, 3, 3, 3>::Type;
using Leaf = Tree::LeafNodeType;
using Lower = Tree::RootNodeType::ChildNodeType::ChildNodeType;
using Upper = Tree::RootNodeType::ChildNodeType;
using Accessor = openvdb::tree::ValueAccessor<Tree>;
using openvdb::Coord;

constexpr int kLeafLog2 = 3;   // cells per leaf and axis, log2
constexpr int kUpperLog2 = 9;  // cells per upper node and axis, log2
constexpr std::size_t kLeafBytes = sizeof(Leaf) + Leaf::SIZE * sizeof(Count);
// Cells of the coarsest and of the finest grid that fit a root cube: its origin is a multiple of
// side / 256, and Morton codes end at side / 2^21.
constexpr double kFewestCells = 256.0;
constexpr double kMostCells = 1 << kMortonDepth;

using Cell = std::array<std::int64_t, 3>;

std::int64_t floor_to_int(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return whole - (value < static_cast<double>(whole) ? 1 : 0);
}

/// Cells anchored at the world's zero, with indices relative to a cell below the cloud: these
/// fit 32 bits even where the distance to zero in cells would overflow 64.
struct Lattice {
  double cell = 0.0;  ///< a power of two
  double cells_per_unit = 0.0;
  Vec3 anchor;  ///< where indices count from; a multiple of the tree's largest node
  double reach = 0.0;
  Vec3 shift, low;

  Lattice() = default;
  /// `side`: of the root cube of `bounds`.
  Lattice(double cell_side, const Box& bounds, double side)
      : cell(cell_side), cells_per_unit(1.0 / cell_side), reach(8.0 * side) {
    // Multiples of the largest node: which cells share a node, and so the memory and the final
    // cell, depend on the points alone and not on who came first.
    const double node = std::ldexp(cell, kUpperLog2);
    for (int axis = 0; axis < 3; ++axis) {
      anchor[axis] = std::floor(bounds.min[axis] / node) * node;
      // Both ways are exact, as in MortonFrame; the side of root cubes up to twice this large
      // keeps p and anchor within a factor of two.
      const bool far = is_far(axis);
      shift[axis] = far ? anchor[axis] : 0.0;
      low[axis] = far ? 0.0 : anchor[axis] * cells_per_unit;
    }
  }
  bool is_far(int axis) const { return std::abs(anchor[axis]) >= reach; }
  /// True when differences to the anchor stay exact within a root cube of that side.
  bool suits(double side) const {
    for (int axis = 0; axis < 3; ++axis)
      if (is_far(axis) && std::abs(anchor[axis]) < 8.0 * side) return false;
    return true;
  }

  int along(double value, int axis) const {
    return static_cast<int>(floor_to_int((value - shift[axis]) * cells_per_unit) -
                            static_cast<std::int64_t>(low[axis]));
  }
  Coord at(Vec3 p) const { return Coord(along(p.x, 0), along(p.y, 1), along(p.z, 2)); }
  Vec3 corner(const Coord& at) const {
    return {anchor.x + at.x() * cell, anchor.y + at.y() * cell, anchor.z + at.z() * cell};
  }
};

/// The anchor's index modulo a power of two beyond all coarsening: lines indices up with zero.
Cell anchor_phase(const Lattice& lattice) {
  const double period = std::ldexp(lattice.cell, kMortonDepth + kUpperLog2);
  Cell phase{};
  for (int axis = 0; axis < 3; ++axis)
    phase[axis] =
        static_cast<std::int64_t>(std::fmod(lattice.anchor[axis], period) * lattice.cells_per_unit);
  return phase;
}

/// Cells from the anchor of one lattice to that of a coarser one, in cells of the finer.
Cell anchor_difference(const Lattice& fine, const Lattice& coarse) {
  Cell difference{};
  for (int axis = 0; axis < 3; ++axis)
    difference[axis] =
        static_cast<std::int64_t>((fine.anchor[axis] - coarse.anchor[axis]) * fine.cells_per_unit);
  return difference;
}

void raise_count(Leaf& leaf, openvdb::Index offset, std::uint64_t by) {
  Count& count = leaf.buffer().data()[offset];
  if (by > std::numeric_limits<Count>::max() - count)
    throw_resource("more than 4294967295 points lie in one cell of the count grid");
  count += static_cast<Count>(by);
  leaf.setActiveState(offset, true);
}

std::size_t nodes_bytes(std::size_t leaves, std::size_t lowers, std::size_t uppers) {
  return leaves * kLeafBytes + lowers * sizeof(Lower) + uppers * sizeof(Upper);
}

/// Halves the coordinates of nodes and merges those that fall together.
void halve(std::vector<Cell>& nodes, int times) {
  for (Cell& node : nodes)
    for (std::int64_t& c : node) c >>= times;
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
}

/// Memory of the tree whose leaves are given (in units of leaves).
std::size_t tree_bytes(const std::vector<Cell>& leaves) {
  std::vector<Cell> lowers = leaves;
  halve(lowers, kLeafLog2);
  std::vector<Cell> uppers = lowers;
  halve(uppers, kLeafLog2);
  return nodes_bytes(leaves.size(), lowers.size(), uppers.size());
}

}  // namespace

struct CountGrid::State {
  std::size_t limit_bytes = 0;
  std::uint64_t points = 0;
  Box bounds;
  // As long as all points are equal there is no scale: they are only counted. After that the
  // tree's coordinates are the lattice's indices.
  bool has_lattice = false;
  Lattice lattice;
  double root_side = 0.0;
  Tree tree{0};
  std::size_t leaves = 0, lowers = 0, uppers = 0;

  std::size_t bytes() const { return nodes_bytes(leaves, lowers, uppers); }
  bool must_coarsen() const { return bytes() > limit_bytes && lattice.cell < coarsest_cell(); }
  /// Beyond it cells would not nest in the root cube.
  double coarsest_cell() const { return root_side / kFewestCells; }
  /// The lattice that all-equal points are reported in.
  Lattice lone_lattice() const {
    const double side = root_cube(bounds).side;
    return Lattice(side / kMostCells, bounds, side);
  }

  void fit_lattice(Vec3 lone_point, std::uint64_t lone_points);
  std::size_t insert(std::span<const Vec3> positions);
  void raise(Accessor& accessor, const Coord& at, std::uint64_t by);
  Leaf* leaf_of(Accessor& accessor, const Coord& at);
  void coarsen_to_limit();
  void coarsen(int levels);
};

/// Makes the lattice right for the bounds as they are now: its cells are no finer than the
/// finest Morton cell of the root cube, so that indices stay small. `lone_points` points at
/// `lone_point` came before there was a lattice.
void CountGrid::State::fit_lattice(Vec3 lone_point, std::uint64_t lone_points) {
  root_side = root_cube(bounds).side;
  const double finest = root_side / kMostCells;
  if (has_lattice) {
    const int levels = std::max(0, std::ilogb(finest) - std::ilogb(lattice.cell));
    if (levels > 0 || !lattice.suits(root_side)) coarsen(levels);
    return;
  }
  has_lattice = true;
  lattice = Lattice(finest, bounds, root_side);
  if (lone_points == 0) return;
  Accessor accessor(tree);
  raise(accessor, lattice.at(lone_point), lone_points);
}

/// The leaf of a cell, made when absent; keeps the books of memory.
Leaf* CountGrid::State::leaf_of(Accessor& accessor, const Coord& at) {
  if (Leaf* leaf = accessor.probeLeaf(at)) return leaf;
  lowers += accessor.probeConstNode<Lower>(at) == nullptr;
  uppers += accessor.probeConstNode<Upper>(at) == nullptr;
  ++leaves;
  return accessor.touchLeaf(at);
}

void CountGrid::State::raise(Accessor& accessor, const Coord& at, std::uint64_t by) {
  raise_count(*leaf_of(accessor, at), Leaf::coordToOffset(at), by);
}

/// Counts points until all are counted or the tree has outgrown its memory; returns how many.
std::size_t CountGrid::State::insert(std::span<const Vec3> positions) {
  Accessor accessor(tree);
  const Lattice cells = lattice;
  Coord run_cell = cells.at(positions.front());
  std::size_t run_begin = 0;
  for (std::size_t i = 1; i < positions.size(); ++i) {
    // Scanned points come in runs of one cell; only the end of a run touches the tree.
    const Coord at = cells.at(positions[i]);
    if (at == run_cell) continue;
    raise(accessor, run_cell, i - run_begin);
    run_cell = at;
    run_begin = i;
    if (must_coarsen()) return i;
  }
  raise(accessor, run_cell, positions.size() - run_begin);
  return positions.size();
}

/// Doubles the cell as often as it takes. How often is found from the leaves alone, so the tree
/// is rebuilt once and ends where doubling step by step would end.
void CountGrid::State::coarsen_to_limit() {
  if (!must_coarsen()) return;
  // The tree's largest nodes line up with the lattice's anchor, but coarser ones line up with
  // the world's zero. Without loss of exactness only the anchor's place among them counts.
  std::vector<Cell> nodes;
  nodes.reserve(leaves);
  const Cell offset = anchor_phase(lattice);
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const Coord& origin = leaf->origin();
    nodes.push_back({(origin.x() + offset[0]) >> kLeafLog2, (origin.y() + offset[1]) >> kLeafLog2,
                     (origin.z() + offset[2]) >> kLeafLog2});
  }
  int levels = 0;
  double coarser = lattice.cell;
  do {
    halve(nodes, 1);
    coarser *= 2.0;
    ++levels;
  } while (coarser < coarsest_cell() && tree_bytes(nodes) > limit_bytes);
  coarsen(levels);
}

/// Rebuilds the tree with cells 2^levels times as wide. Old leaves go as they are read.
void CountGrid::State::coarsen(int levels) {
  std::vector<Leaf*> old_leaves;
  old_leaves.reserve(leaves);
  tree.stealNodes(old_leaves);
  tree.clear();
  leaves = lowers = uppers = 0;
  const Lattice coarse(std::ldexp(lattice.cell, levels), bounds, root_side);
  const Cell offset = anchor_difference(lattice, coarse);
  lattice = coarse;
  Accessor accessor(tree);
  for (Leaf* stolen : old_leaves) {
    const std::unique_ptr<Leaf> leaf(stolen);
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      const Coord at = value.getCoord();
      const Coord merged(static_cast<int>((at.x() + offset[0]) >> levels),
                         static_cast<int>((at.y() + offset[1]) >> levels),
                         static_cast<int>((at.z() + offset[2]) >> levels));
      raise(accessor, merged, value.getValue());
    }
  }
}

CountGrid::CountGrid(std::size_t limit_bytes) : state_(std::make_unique<State>()) {
  state_->limit_bytes = limit_bytes;
}
CountGrid::~CountGrid() = default;
CountGrid::CountGrid(CountGrid&&) noexcept = default;
CountGrid& CountGrid::operator=(CountGrid&&) noexcept = default;

void CountGrid::add(std::span<const Vec3> positions) {
  if (positions.empty()) return;
  State& state = *state_;
  const Vec3 lone_point = state.points > 0 ? state.bounds.min : positions.front();
  const std::uint64_t lone_points = state.has_lattice ? 0 : state.points;
  for (const Vec3& p : positions) state.bounds.extend(p);
  state.points += positions.size();
  if (!(state.bounds.largest_extent() > 0.0)) return;
  state.fit_lattice(lone_point, lone_points);
  while (!positions.empty()) {
    positions = positions.subspan(state.insert(positions));
    state.coarsen_to_limit();
  }
}

void CountGrid::settle(double root_side) {
  State& state = *state_;
  if (!state.has_lattice) return;
  const double finest = root_side / kMostCells;
  if (state.lattice.cell < finest)
    state.coarsen(std::ilogb(finest) - std::ilogb(state.lattice.cell));
  if (state.lattice.cell > root_side / kFewestCells)
    throw std::logic_error("CountGrid::settle: the root cube is smaller than the cloud");
}

std::uint64_t CountGrid::points() const { return state_->points; }
const Box& CountGrid::bounds() const { return state_->bounds; }
std::size_t CountGrid::memory_bytes() const { return state_->bytes(); }

double CountGrid::cell() const {
  if (state_->points == 0) return 1.0;
  return state_->has_lattice ? state_->lattice.cell : state_->lone_lattice().cell;
}

void CountGrid::for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const {
  const State& state = *state_;
  if (state.points == 0) return;
  if (!state.has_lattice) {
    const Lattice lattice = state.lone_lattice();
    return visit(lattice.corner(lattice.at(state.bounds.min)), state.points);
  }
  for (auto leaf = state.tree.cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value)
      visit(state.lattice.corner(value.getCoord()), value.getValue());
}

}  // namespace orbweave
