#include "engine/stitching/mesh_summary.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "engine/geometry/loop_path.h"
#include "io/whole_loop.h"

namespace orbweave {

namespace {

/// The walks along the boundary. Every boundary edge leaves a fan at its tail and ends one at its
/// head: an edge is the fan at its tail. Beside the fans this takes 9 bytes per edge, and what the
/// longest walk takes.
class LoopWalks {
 public:
  explicit LoopWalks(std::span<const OpenFan> fans)
      : fans_(fans), arriving_(fans.size()), next_(fans.size()), done_(fans.size(), false) {
    std::iota(arriving_.begin(), arriving_.end(), 0u);
    tbb::parallel_sort(arriving_.begin(), arriving_.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return fans[a] < fans[b]; });
    constexpr std::size_t kEdgesAtOnce = 4096;
    for_each_whole((next_.size() + kEdgesAtOnce - 1) / kEdgesAtOnce, [&](std::size_t block) {
      const std::size_t end = std::min(next_.size(), (block + 1) * kEdgesAtOnce);
      for (std::size_t edge = block * kEdgesAtOnce; edge < end; ++edge)
        next_[edge] = find_next(static_cast<std::uint32_t>(edge));
    });
  }

  std::uint64_t count() {
    for (std::uint32_t edge = 0; edge < arriving_.size(); ++edge)
      if (!done_[edge]) walk(edge);
    return path_.loops();
  }

 private:
  const OpenFan& fan(std::uint32_t edge) const { return fans_[arriving_[edge]]; }

  /// The edge that leaves the fan which `edge` ends; the number of edges where there is none.
  std::uint32_t find_next(std::uint32_t edge) const {
    const std::uint64_t tail = fan(edge).vertex, head = fan(edge).next;
    const auto at = std::partition_point(arriving_.begin(), arriving_.end(), [&](std::uint32_t i) {
      return std::tie(fans_[i].previous, fans_[i].vertex) < std::tie(tail, head);
    });
    const bool found =
        at != arriving_.end() && fans_[*at].previous == tail && fans_[*at].vertex == head;
    return static_cast<std::uint32_t>((found ? at : arriving_.end()) - arriving_.begin());
  }

  void walk(std::uint32_t edge) {
    path_.begin(fan(edge).vertex);
    while (edge < arriving_.size() && !done_[edge]) {
      done_[edge] = true;
      path_.arrive(fan(edge).next);
      edge = next_[edge];
    }
    path_.end();
  }

  std::span<const OpenFan> fans_;
  std::vector<std::uint32_t> arriving_;  // by (previous, vertex): the arriving edge
  std::vector<std::uint32_t> next_;
  std::vector<bool> done_;
  LoopPath<std::uint64_t> path_;
};

}  // namespace

std::uint64_t count_loops(std::span<const OpenFan> fans) { return LoopWalks(fans).count(); }

void derive_facts(MeshFacts& facts) {
  const std::uint64_t edges = (3 * facts.triangles + facts.boundary_edges) / 2;
  facts.euler_characteristic = static_cast<std::int64_t>(facts.vertices) -
                               static_cast<std::int64_t>(edges) +
                               static_cast<std::int64_t>(facts.triangles);
  facts.watertight =
      facts.triangles > 0 && facts.boundary_edges == 0 && facts.nonmanifold_vertices == 0;
}

void MeshSummary::reserve(std::uint64_t fans, std::uint64_t vertices, std::uint64_t pieces) {
  boundary_.fans.reserve(fans);
  if (keeps_vertices_) boundary_.vertices.reserve(vertices);
  boundary_.pieces.reserve(pieces);
}

void MeshSummary::add(const ChunkMesh& chunk, std::uint64_t first_vertex, std::uint64_t triangles) {
  facts_.triangles += triangles;
  facts_.area += chunk.area;
  facts_.scanned_volume += chunk.volume;
  conflicts_lost_ += chunk.conflicts_lost;
  voronoi_ += chunk.voronoi;
  sides_ += chunk.sides;
  count_fans(chunk.fans, first_vertex);
  const std::uint64_t before = boundary_.pieces.size();
  for (OpenFan fan : chunk.boundary) {
    fan.component += before;
    boundary_.fans.push_back(fan);
  }
  for (const SeamNode& node : chunk.seam)
    seam_.push_back({node.vertex, node.fan, node.component + before});
  runs_.push_back(seam_.size());
  if (keeps_vertices_) {
    boundary_.vertices.insert(boundary_.vertices.end(), chunk.boundary_vertices.begin(),
                              chunk.boundary_vertices.end());
  }
  boundary_.pieces.insert(boundary_.pieces.end(), chunk.pieces.begin(), chunk.pieces.end());
  while (sets_.size() < boundary_.pieces.size()) sets_.add();
  ++chunks_;
  if (seam_.size() > settle_at_) settle_seams();
}

/// Most blocks of points have no point of several fans, and are only counted.
void MeshSummary::count_fans(std::span<const std::uint8_t> fans, std::uint64_t first_vertex) {
  constexpr std::size_t kBlock = 4096;
  for (std::size_t begin = 0; begin < fans.size(); begin += kBlock) {
    const auto block = fans.subspan(begin, std::min(kBlock, fans.size() - begin));
    std::uint8_t most = 0;
    for (const std::uint8_t count : block) most = std::max(most, count);
    const auto unused =
        static_cast<std::uint64_t>(std::count(block.begin(), block.end(), std::uint8_t{0}));
    facts_.vertices += block.size() - unused;
    unused_points_ += unused;
    if (most <= 1) continue;
    for (std::size_t i = 0; i < block.size(); ++i)
      if (block[i] > 1) boundary_.pinched.push_back(first_vertex + begin + i);
  }
}

/// Merges the sorted nodes of the chunks, run by run, in a second list as long as the first.
void MeshSummary::sort_seam() {
  std::vector<SeamNode> merged;
  while (runs_.size() > 2) {
    merged.resize(seam_.size());
    std::vector<std::size_t> begins = {0};
    for (std::size_t r = 0; r + 1 < runs_.size(); r += 2) {
      const auto at = [&](std::size_t run) {
        return seam_.begin() + static_cast<std::ptrdiff_t>(runs_[std::min(run, runs_.size() - 1)]);
      };
      std::merge(at(r), at(r + 1), at(r + 1), at(r + 2),
                 merged.begin() + static_cast<std::ptrdiff_t>(runs_[r]));
      begins.push_back(runs_[std::min(r + 2, runs_.size() - 1)]);
    }
    seam_.swap(merged);
    runs_.swap(begins);
  }
}

/// Pieces of different chunks are one where they share a node; what no later chunk can share goes.
void MeshSummary::settle_seams() {
  constexpr std::size_t kLeastNodes = std::size_t{1} << 16;
  sort_seam();
  std::size_t kept = 0;
  for (const SeamNode& node : seam_) {
    const SeamNode* last = kept == 0 ? nullptr : &seam_[kept - 1];
    if (last != nullptr && last->vertex == node.vertex && last->fan == node.fan) {
      sets_.unite(static_cast<std::uint32_t>(last->component),
                  static_cast<std::uint32_t>(node.component));
    } else {
      seam_[kept++] = node;
    }
  }
  seam_.resize(kept);
  if (last_use_) {
    Users users;
    std::erase_if(seam_, [&](const SeamNode& node) {
      if (node.vertex >= users.end) users = last_use_(node.vertex);
      return users.last < chunks_;
    });
  }
  runs_ = {0, seam_.size()};
  settle_at_ = std::max(kLeastNodes, 2 * seam_.size());
}

void MeshSummary::join_pieces() {
  settle_seams();
  seam_ = {};
  last_use_ = {};
  // In place: a whole's number is never above that of its first part.
  std::vector<ChunkPiece>& pieces = boundary_.pieces;
  std::vector<std::uint32_t> number(pieces.size());
  std::uint32_t wholes = 0;
  for (std::uint32_t p = 0; p < pieces.size(); ++p) {
    const ChunkPiece part = pieces[p];
    const std::uint32_t root = sets_.find(p);  // the first of its set
    number[p] = root == p ? wholes++ : number[root];
    ChunkPiece& whole = pieces[number[p]];
    if (root == p) whole = ChunkPiece();
    // Chunks come in canonical order: the first part that has a triangle has the smallest.
    if (whole.triangles == 0) whole.first = part.first;
    whole.triangles += part.triangles;
    whole.box.extend(part.box);
  }
  pieces.resize(wholes);
  sets_ = DisjointSets(0);
  for (OpenFan& fan : boundary_.fans) fan.component = number[fan.component];
}

void MeshSummary::finish() {
  join_pieces();
  facts_.boundary_edges = boundary_.fans.size();
  facts_.boundary_loops = count_loops(boundary_.fans);
  facts_.components = boundary_.pieces.size();
  facts_.nonmanifold_vertices = boundary_.pinched.size();
  facts_.pinches = facts_.nonmanifold_vertices;
  derive_facts(facts_);
}

}  // namespace orbweave
