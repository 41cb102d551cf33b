#include "partition/octree.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "io/error.h"
#include "io/first_touch.h"
#include "partition/radix_sort.h"

namespace orbweave {
namespace {

constexpr int kCodeBits = 3 * kMortonDepth;

/// Codes in a node at that depth.
constexpr std::uint64_t span_of(int depth) { return std::uint64_t{1} << (kCodeBits - 3 * depth); }

/// Cube of the node at `depth` whose first code is `begin`. Rounding is monotonic: the cube of a
/// node holds those of its descendants, and every point whose code is the node's.
Box node_box(const RootCube& root, std::uint64_t begin, int depth) {
  const double cell = root.cell(kMortonDepth);
  const double width = std::ldexp(1.0, kMortonDepth - depth);
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const double first = deinterleave(begin, axis);
    box.min[axis] = root.origin[axis] + first * cell;
    box.max[axis] = root.origin[axis] + (first + width) * cell;
  }
  return box;
}

/// The grid's cells in Morton order, with sums of their counts.
struct CodedCells {
  KeyList cells;                          ///< first code; index into counts
  std::vector<std::uint64_t> sum_before;  ///< points before the i-th cell in Morton order
};

CodedCells code_cells(const PointCounts& grid, const RootCube& root) {
  const MortonFrame frame(root);
  CodedCells coded{KeyList(grid.cells()), {}};
  UnsetVector<std::uint64_t> counts(coded.cells.size());
  grid.for_each_at_once([&](std::size_t cell, Vec3 corner, std::uint64_t count) {
    coded.cells[cell] = {frame.code(corner), static_cast<std::uint32_t>(cell)};
    counts[cell] = count;
  });
  radix_sort(coded.cells);
  coded.sum_before.reserve(counts.size() + 1);
  coded.sum_before.push_back(0);
  for (const KeyIndex& cell : coded.cells)
    coded.sum_before.push_back(coded.sum_before.back() + counts[cell.index]);
  return coded;
}

class Cutter {
 public:
  Cutter(const CodedCells& coded, const RootCube& root, std::uint64_t chunk_points, int depth_limit)
      : coded_(coded), root_(root), chunk_points_(chunk_points), depth_limit_(depth_limit) {}

  /// Cuts the node whose cells are [first, last).
  void cut(std::size_t first, std::size_t last, std::uint64_t begin, int depth) {
    if (first == last) return;
    const std::uint64_t points = coded_.sum_before[last] - coded_.sum_before[first];
    if (points <= chunk_points_ || depth == depth_limit_) {
      chunks.push_back(
          {begin, begin + span_of(depth), depth, node_box(root_, begin, depth), points});
      return;
    }
    const std::uint64_t child_span = span_of(depth + 1);
    for (std::uint64_t child = 0; child < 8; ++child) {
      const std::uint64_t child_begin = begin + child * child_span;
      const std::size_t child_last = end_of(first, last, child_begin + child_span);
      cut(first, child_last, child_begin, depth + 1);
      first = child_last;
    }
  }

  /// Cuts a node that is a chunk already.
  void cut(const Chunk& chunk) {
    const std::size_t cells = coded_.cells.size();
    const std::size_t first = end_of(0, cells, chunk.code_begin);
    cut(first, end_of(first, cells, chunk.code_end), chunk.code_begin, chunk.depth);
  }

  std::vector<Chunk> chunks;

 private:
  /// The first cell from `first` on that does not begin before that code.
  std::size_t end_of(std::size_t first, std::size_t last, std::uint64_t code_end) const {
    const auto begin = coded_.cells.begin();
    const auto end =
        std::lower_bound(begin + first, begin + last, code_end,
                         [](const KeyIndex& cell, std::uint64_t code) { return cell.key < code; });
    return static_cast<std::size_t>(end - begin);
  }

  const CodedCells& coded_;
  const RootCube& root_;
  std::uint64_t chunk_points_;
  int depth_limit_;
};

/// Puts chunks together, as Cutter takes cells apart.
class Merger {
 public:
  Merger(const Octree& octree, std::uint64_t chunk_points)
      : octree_(octree), chunk_points_(chunk_points) {}

  /// Merges below the node whose chunks are [first, last).
  void merge(std::size_t first, std::size_t last, std::uint64_t begin, int depth) {
    const std::vector<Chunk>& fine = octree_.chunks();
    if (first == last) return;
    if (last - first == 1) return chunks.push_back(fine[first]);
    std::uint64_t points = 0;
    for (std::size_t i = first; i < last; ++i) points += fine[i].points;
    if (points <= chunk_points_) {
      chunks.push_back(
          {begin, begin + span_of(depth), depth, node_box(octree_.root(), begin, depth), points});
      return;
    }
    const std::uint64_t child_span = span_of(depth + 1);
    for (std::uint64_t child = 0; child < 8; ++child) {
      const std::uint64_t child_begin = begin + child * child_span;
      std::size_t child_last = first;
      while (child_last < last && fine[child_last].code_begin < child_begin + child_span)
        ++child_last;
      merge(first, child_last, child_begin, depth + 1);
      first = child_last;
    }
  }

  std::vector<Chunk> chunks;

 private:
  const Octree& octree_;
  std::uint64_t chunk_points_;
};

}  // namespace

/// A node on the way down to the neighbours, with the chunks inside it.
struct Octree::Node {
  std::uint64_t begin;
  int depth;
  ChunkId first, last;
};

Octree::Octree(RootCube root, std::vector<Chunk> chunks)
    : root_(root), frame_(root), chunks_(std::move(chunks)) {
  begins_.reserve(chunks_.size());
  for (const Chunk& chunk : chunks_) begins_.push_back(chunk.code_begin);
  // Eight ranges per chunk, at least 8 and at most 2^18 (one megabyte).
  const int bits = std::clamp(static_cast<int>(std::bit_width(chunks_.size())) + 3, 3, 18);
  shift_ = kCodeBits - bits;
  first_.reserve((std::size_t{1} << bits) + 1);
  ChunkId chunk = 0;
  for (std::uint64_t range = 0; range <= std::uint64_t{1} << bits; ++range) {
    while (chunk < chunks_.size() && chunks_[chunk].code_end <= range << shift_) ++chunk;
    first_.push_back(chunk);
  }
}

std::uint64_t Octree::points() const {
  std::uint64_t points = 0;
  for (const Chunk& chunk : chunks_) points += chunk.points;
  return points;
}

ChunkId Octree::chunk_of(Vec3 p) const { return chunk_of_code(frame_.code(p)); }

ChunkId Octree::chunk_of_code(std::uint64_t code) const {
  if (!chunks_.empty() && code >> kCodeBits == 0) {
    const std::uint64_t range = code >> shift_;
    // The owner ends after the range begins, and begins before the range ends.
    const auto last = std::min<std::size_t>(std::size_t{first_[range + 1]} + 1, chunks_.size());
    const auto after =
        std::upper_bound(begins_.begin() + first_[range], begins_.begin() + last, code);
    if (after != begins_.begin()) {
      const auto chunk = static_cast<ChunkId>(after - begins_.begin() - 1);
      if (code < chunks_[chunk].code_end) return chunk;
    }
  }
  throw_bad_input("a point lies where none was counted",
                  {.advice = "The input changed while it was read; run again"});
}

std::vector<ChunkId> Octree::neighbors(ChunkId self, double halo_width) const {
  std::vector<ChunkId> found;
  const Node root{0, 0, 0, static_cast<ChunkId>(chunks_.size())};
  collect(root, chunks_.at(self).box.grown(halo_width), self, found);
  return found;
}

void Octree::collect(const Node& node, const Box& reach, ChunkId self,
                     std::vector<ChunkId>& out) const {
  if (node.last - node.first <= 4) {
    for (ChunkId chunk = node.first; chunk < node.last; ++chunk)
      if (chunk != self && reach.intersects(chunks_[chunk].box)) out.push_back(chunk);
    return;
  }
  ChunkId first = node.first;
  const std::uint64_t child_span = span_of(node.depth + 1);
  for (std::uint64_t child = 0; child < 8 && first < node.last; ++child) {
    const std::uint64_t begin = node.begin + child * child_span;
    const auto end =
        std::lower_bound(begins_.begin() + first, begins_.begin() + node.last, begin + child_span);
    const auto last = static_cast<ChunkId>(end - begins_.begin());
    if (first < last && reach.intersects(node_box(root_, begin, node.depth + 1)))
      collect({begin, node.depth + 1, first, last}, reach, self, out);
    first = last;
  }
}

namespace {

/// Depth of the nodes that are a cell wide.
int depth_of_cells(const PointCounts& grid, const RootCube& root) {
  // Powers of two: the quotient is exact.
  const int depth = std::ilogb(root.side / grid.cell());
  if (depth < 8 || depth > kMortonDepth)
    throw std::logic_error("octree: the count grid is not settled for this root cube");
  return depth;
}

}  // namespace

Octree cut_octree(const PointCounts& grid, const RootCube& root, std::uint64_t chunk_points) {
  if (grid.points() == 0) return Octree(root, {});
  const int depth_limit = depth_of_cells(grid, root);
  if (grid.points() <= chunk_points)
    return Octree(root, {{0, span_of(0), 0, node_box(root, 0, 0), grid.points()}});
  const CodedCells coded = code_cells(grid, root);
  Cutter cutter(coded, root, chunk_points, depth_limit);
  cutter.cut(0, coded.cells.size(), 0, 0);
  return Octree(root, std::move(cutter.chunks));
}

Octree refined(const Octree& octree, std::span<const ChunkId> dense, const PointCounts& grid,
               std::uint64_t chunk_points) {
  const RootCube& root = octree.root();
  const int depth_limit = depth_of_cells(grid, root);
  const CodedCells coded = code_cells(grid, root);
  Cutter cutter(coded, root, chunk_points, depth_limit);
  for (ChunkId chunk = 0; chunk < octree.chunks().size(); ++chunk) {
    const bool finer = std::binary_search(dense.begin(), dense.end(), chunk) &&
                       octree.chunks()[chunk].depth < depth_limit;
    if (finer)
      cutter.cut(octree.chunks()[chunk]);
    else
      cutter.chunks.push_back(octree.chunks()[chunk]);
  }
  return Octree(root, std::move(cutter.chunks));
}

Octree coarsened(const Octree& octree, std::uint64_t chunk_points) {
  Merger merger(octree, chunk_points);
  merger.merge(0, octree.chunks().size(), 0, 0);
  return Octree(octree.root(), std::move(merger.chunks));
}

}  // namespace orbweave
