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

using Cell = std::array<std::int64_t, 3>;  // index on the lattice anchored at the world's zero

std::int64_t floor_to_int(double value) {
  const auto whole = static_cast<std::int64_t>(value);
  return whole - (value < static_cast<double>(whole) ? 1 : 0);
}

Cell cell_of(Vec3 p, double cells_per_unit) {
  return {floor_to_int(p.x * cells_per_unit), floor_to_int(p.y * cells_per_unit),
          floor_to_int(p.z * cells_per_unit)};
}

Coord coord_of(const Cell& cell, const Cell& base) {
  return Coord(static_cast<int>(cell[0] - base[0]), static_cast<int>(cell[1] - base[1]),
               static_cast<int>(cell[2] - base[2]));
}

Vec3 corner_of(const Cell& cell, double side) {
  return {static_cast<double>(cell[0]) * side, static_cast<double>(cell[1]) * side,
          static_cast<double>(cell[2]) * side};
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
  // lattice is `cell` wide and tree coordinates are relative to `base`.
  bool has_lattice = false;
  double cell = 0.0;
  double coarsest_cell = 0.0;  // beyond it cells would not nest in the root cube
  Cell base{};
  Tree tree{0};
  std::size_t leaves = 0, lowers = 0, uppers = 0;

  std::size_t bytes() const { return nodes_bytes(leaves, lowers, uppers); }
  bool must_coarsen() const { return bytes() > limit_bytes && cell < coarsest_cell; }
  /// Cell that all-equal points are reported in.
  double lone_cell() const { return root_cube(bounds).side / kMostCells; }

  void fit_lattice(Vec3 lone_point, std::uint64_t lone_points);
  std::size_t insert(std::span<const Vec3> positions);
  void raise(Accessor& accessor, const Coord& at, std::uint64_t by);
  Leaf* leaf_of(Accessor& accessor, const Coord& at);
  void choose_base();
  void coarsen_to_limit();
  void coarsen(int levels);
};

void CountGrid::State::choose_base() {
  base = cell_of(bounds.min, 1.0 / cell);
  // Multiples of the tree's largest node: which cells share a node, and so the memory and the
  // final cell, depend on the points alone and not on who came first.
  for (std::int64_t& b : base) b = (b >> kUpperLog2) * (std::int64_t{1} << kUpperLog2);
}

/// Makes the lattice right for the bounds as they are now: its cells are no finer than the
/// finest Morton cell of the root cube, so that indices stay small. `lone_points` points at
/// `lone_point` came before there was a lattice.
void CountGrid::State::fit_lattice(Vec3 lone_point, std::uint64_t lone_points) {
  const double side = root_cube(bounds).side;
  coarsest_cell = side / kFewestCells;
  const double finest = side / kMostCells;
  if (has_lattice) {
    if (cell < finest) coarsen(std::ilogb(finest) - std::ilogb(cell));
    return;
  }
  has_lattice = true;
  cell = finest;
  choose_base();
  if (lone_points == 0) return;
  Accessor accessor(tree);
  raise(accessor, coord_of(cell_of(lone_point, 1.0 / cell), base), lone_points);
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
  const double cells_per_unit = 1.0 / cell;
  Cell run_cell = cell_of(positions.front(), cells_per_unit);
  std::size_t run_begin = 0;
  for (std::size_t i = 1; i < positions.size(); ++i) {
    // Scanned points come in runs of one cell; only the end of a run touches the tree.
    const Cell at = cell_of(positions[i], cells_per_unit);
    if (at == run_cell) continue;
    raise(accessor, coord_of(run_cell, base), i - run_begin);
    run_cell = at;
    run_begin = i;
    if (must_coarsen()) return i;
  }
  raise(accessor, coord_of(run_cell, base), positions.size() - run_begin);
  return positions.size();
}

/// Doubles the cell as often as it takes. How often is found from the leaves alone, so the tree
/// is rebuilt once and ends where doubling step by step would end.
void CountGrid::State::coarsen_to_limit() {
  if (!must_coarsen()) return;
  std::vector<Cell> nodes;
  nodes.reserve(leaves);
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const Coord& origin = leaf->origin();
    nodes.push_back({(origin.x() + base[0]) >> kLeafLog2, (origin.y() + base[1]) >> kLeafLog2,
                     (origin.z() + base[2]) >> kLeafLog2});
  }
  int levels = 0;
  double coarser = cell;
  do {
    halve(nodes, 1);
    coarser *= 2.0;
    ++levels;
  } while (coarser < coarsest_cell && tree_bytes(nodes) > limit_bytes);
  coarsen(levels);
}

/// Rebuilds the tree with cells 2^levels times as wide. Old leaves go as they are read.
void CountGrid::State::coarsen(int levels) {
  std::vector<Leaf*> old_leaves;
  old_leaves.reserve(leaves);
  tree.stealNodes(old_leaves);
  tree.clear();
  leaves = lowers = uppers = 0;
  const Cell old_base = base;
  cell = std::ldexp(cell, levels);
  choose_base();
  Accessor accessor(tree);
  for (Leaf* stolen : old_leaves) {
    const std::unique_ptr<Leaf> leaf(stolen);
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      const Coord at = value.getCoord();
      const Cell coarse = {(at.x() + old_base[0]) >> levels, (at.y() + old_base[1]) >> levels,
                           (at.z() + old_base[2]) >> levels};
      raise(accessor, coord_of(coarse, base), value.getValue());
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
  if (state.cell < finest) state.coarsen(std::ilogb(finest) - std::ilogb(state.cell));
  if (state.cell > root_side / kFewestCells)
    throw std::logic_error("CountGrid::settle: the root cube is smaller than the cloud");
}

std::uint64_t CountGrid::points() const { return state_->points; }
const Box& CountGrid::bounds() const { return state_->bounds; }
std::size_t CountGrid::memory_bytes() const { return state_->bytes(); }

double CountGrid::cell() const {
  if (state_->points == 0) return 1.0;
  return state_->has_lattice ? state_->cell : state_->lone_cell();
}

void CountGrid::for_each(const std::function<void(Vec3, std::uint64_t)>& visit) const {
  const State& state = *state_;
  if (state.points == 0) return;
  if (!state.has_lattice) {
    const double cell = state.lone_cell();
    return visit(corner_of(cell_of(state.bounds.min, 1.0 / cell), cell), state.points);
  }
  for (auto leaf = state.tree.cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      const Coord at = value.getCoord();
      const Cell cell = {at.x() + state.base[0], at.y() + state.base[1], at.z() + state.base[2]};
      visit(corner_of(cell, state.cell), value.getValue());
    }
}

}  // namespace orbweave
