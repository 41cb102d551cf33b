// Patches of points: what a cell of the lattice holds of one sheet, and their votes.
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <numeric>
#include <tuple>

#include "engine/geometry/neighbor_search.h"
#include "engine/geometry/symmetric_eigen.h"
#include "engine/normals/orientation.h"
#include "engine/normals/orientation_graph.h"
#include "engine/normals/orientation_vote.h"
#include "engine/normals/point_row.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kBlock = NeighborSearch::kBlock;
/// Edges within a cell with votes of at least this size join their points at once.
constexpr double kConfident = 0.97;
/// What these leave is joined in the order of its votes, as long as they are this unanimous; the
/// rest is left to the graph of all patches.
constexpr double kUnanimous = 0.8;

bool is_zero(Vec3 v) { return v == Vec3{}; }

/// Points of one cell of the lattice: rows [begin, end) of `members`, ascending.
struct Cell {
  Vec3 corner;  // in cells
  std::uint32_t begin = 0, end = 0;
};

/// Points grouped by cell. In canonical order the points of a cell follow each other, unless cells
/// are finer than the order; hence runs are sorted, not points.
struct Cells {
  std::vector<Cell> cells;
  std::vector<std::uint32_t> members;
  std::vector<std::uint32_t> cell_of;

  Cells(std::span<const Vec3> positions, double side) {
    struct Run {
      Vec3 corner;
      std::uint32_t begin, end;
    };
    std::vector<Run> runs;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
      const Vec3 p = positions[i];
      const Vec3 corner{std::floor(p.x / side), std::floor(p.y / side), std::floor(p.z / side)};
      if (!runs.empty() && runs.back().corner == corner) {
        runs.back().end = i + 1;
      } else {
        runs.push_back({corner, i, i + 1});
      }
    }
    std::sort(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
      return std::tie(a.corner.x, a.corner.y, a.corner.z, a.begin) <
             std::tie(b.corner.x, b.corner.y, b.corner.z, b.begin);
    });
    cell_of.resize(positions.size());
    members.reserve(positions.size());
    for (const Run& run : runs) {
      const auto at = static_cast<std::uint32_t>(members.size());
      if (cells.empty() || !(cells.back().corner == run.corner))
        cells.push_back({run.corner, at, at});
      for (std::uint32_t i = run.begin; i < run.end; ++i) {
        members.push_back(i);
        cell_of[i] = static_cast<std::uint32_t>(cells.size() - 1);
      }
      cells.back().end = static_cast<std::uint32_t>(members.size());
    }
  }
};

/// Between two positions in a cell, a < b.
struct Edge {
  std::uint32_t a = 0, b = 0;
  double votes = 0.0;
};

/// The strongest first; no two different edges are equal.
void sort_by_votes(std::vector<Edge>& edges) {
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
    if (std::abs(x.votes) != std::abs(y.votes)) return std::abs(x.votes) > std::abs(y.votes);
    return std::tie(x.a, x.b, x.votes) < std::tie(y.a, y.b, y.votes);
  });
}

/// Union-find that knows whether a member is turned against its root.
class Signs {
 public:
  /// A member's root, and whether the member is turned against it.
  struct Root {
    std::uint32_t member = 0;
    std::uint32_t turn = 0;  ///< 0 or 1
  };

  void reset(std::uint32_t size) {
    links_.resize(size);
    for (std::uint32_t x = 0; x < size; ++x) links_[x] = link_to(x, 0);
  }
  /// Halves the way to the root.
  Root find(std::uint32_t x) {
    std::uint32_t turn = 0;
    while (member_of(links_[x]) != x) {
      const std::uint32_t next = links_[member_of(links_[x])];  // a root's turn is 0
      links_[x] = next ^ (links_[x] & 1);
      turn ^= links_[x] & 1;
      x = member_of(next);
    }
    return {x, turn};
  }
  /// The smaller root stays. Whether a and b are now to each other as asked for: not so if they
  /// were joined the other way before.
  bool join(std::uint32_t a, std::uint32_t b, bool opposite) {
    const Root root_a = find(a), root_b = find(b);
    const std::uint32_t turn = root_a.turn ^ root_b.turn ^ (opposite ? 1U : 0U);
    if (root_a.member == root_b.member) return turn == 0;
    const auto [smaller, larger] = std::minmax(root_a.member, root_b.member);
    links_[larger] = link_to(smaller, turn);
    return true;
  }

 private:
  // The parent and, in the lowest bit, whether the member is turned against it: a cell has far
  // fewer members than half of what 32 bits can number.
  static std::uint32_t link_to(std::uint32_t parent, std::uint32_t turn) {
    return parent << 1 | turn;
  }
  static std::uint32_t member_of(std::uint32_t link) { return link >> 1; }

  std::vector<std::uint32_t> links_;
};

class Patches {
 public:
  Patches(std::span<const Vec3> positions, std::span<const Vec3> normals,
          std::span<const std::uint64_t> global, std::uint32_t begin, std::uint32_t end,
          const OrientationOptions& options)
      : positions_(positions),
        normals_(normals),
        global_(global),
        begin_(begin),
        end_(end),
        options_(options),
        cells_(positions, options.cell),
        search_(positions),
        state_(cells_.cells.size(), kUnknown),
        neighbors_(
            std::make_unique_for_overwrite<std::uint32_t[]>(positions.size() * options.neighbors)),
        counts_(positions.size(), 0),
        radius_(positions.size(), 0.0),
        first_(positions.size(), kNobody),
        turn_(positions.size(), 0) {}

  OrientedPatches run() {
    for (std::uint32_t i = begin_; i < end_; ++i) state_[cells_.cell_of[i]] = kAsked;
    find_neighbors();
    const std::vector<std::uint8_t> own = state_;
    if (std::ranges::find(own, kUnknown) != own.end()) find_neighbors_beyond(own);
    form_patches();
    return result(own);
  }

 private:
  enum State : std::uint8_t { kUnknown, kAsked, kDone };

  /// Of the points in cells that neighbours of own cells lie in.
  void find_neighbors_beyond(const std::vector<std::uint8_t>& own) {
    for (std::uint32_t i = 0; i < positions_.size(); ++i) {
      if (own[cells_.cell_of[i]] != kDone) continue;
      for (const std::uint32_t q : neighbors(i))
        if (state_[cells_.cell_of[q]] == kUnknown) state_[cells_.cell_of[q]] = kAsked;
    }
    find_neighbors();
  }

  std::span<const std::uint32_t> neighbors(std::uint32_t i) const {
    return {neighbors_.get() + i * options_.neighbors, counts_[i]};
  }

  bool asked(std::uint32_t i) const {
    return state_[cells_.cell_of[i]] == kAsked && !is_zero(normals_[i]);
  }

  /// Of the points of all cells asked for, which are then done.
  void find_neighbors() {
    const auto blocks = static_cast<std::uint32_t>((positions_.size() + kBlock - 1) / kBlock);
    tbb::enumerable_thread_specific<std::array<NeighborSearch::Query, 2>> queries;
    using Range = tbb::blocked_range<std::uint32_t>;
    tbb::parallel_for(Range(0, blocks, 32), [&](const Range& range) {
      auto& [query, wider] = queries.local();
      for (std::uint32_t b = range.begin(); b < range.end(); ++b)
        neighbors_of_block(b, query, wider);
    });
    for (std::uint8_t& state : state_)
      if (state == kAsked) state = kDone;
  }

  /// What voters() works in; reuse it.
  struct Voters {
    std::vector<Neighbor> by_distance;
    std::vector<std::uint32_t> chosen;
  };

  /// Those of a point's neighbours that vote. Of more than vote, some are near and some are far: on
  /// a scan line the nearest are all of that line.
  std::span<const std::uint32_t> voters(std::span<const std::uint32_t> found,
                                        std::span<const double> squared, Voters& scratch) const {
    auto& [by_distance, chosen] = scratch;
    if (found.size() <= options_.neighbors) return found;
    by_distance.clear();
    for (std::size_t i = 0; i < found.size(); ++i) by_distance.push_back({squared[i], found[i]});
    std::sort(by_distance.begin(), by_distance.end(), kNearerFirst);
    chosen.clear();
    for (std::size_t i = 0; i < options_.neighbors; ++i)
      chosen.push_back(by_distance[i * found.size() / options_.neighbors].index);
    return chosen;
  }

  /// Whether points found lie nearly on a line.
  bool is_row(std::span<const std::uint32_t> found, std::uint32_t i) const {
    Vec3 center;
    for (const std::uint32_t n : found) center = center + (positions_[n] - positions_[i]);
    center = center / static_cast<double>(found.size());
    SymmetricMatrix spread;
    for (const std::uint32_t n : found) spread += outer(positions_[n] - positions_[i] - center);
    // Eigenvalues take time. The products of two each are together below 2.01 * kNearlyALine of the
    // squared sum where the points lie on a line: most points are told off it by that.
    constexpr double kMostOfRow = 2.1 * kNearlyALine;
    const double sum = spread.xx + spread.yy + spread.zz;
    const double products = spread.xx * spread.yy - spread.xy * spread.xy + spread.xx * spread.zz -
                            spread.xz * spread.xz + spread.yy * spread.zz - spread.yz * spread.yz;
    if (products > kMostOfRow * sum * sum) return false;
    return nearly_a_line(eigen_of(spread));
  }

  /// Asks for more neighbours where all that are found lie nearly on a line: those of a ring around
  /// the axis of a scanner are joined to no other ring otherwise, and each takes its own side.
  /// False where the wider search finds nothing but the line, or the line ends within the radius.
  bool look_beside_row(std::uint32_t i, std::size_t among, NeighborSearch::Query& wider) const {
    for (std::size_t count = 2 * among; count <= kMostEnlarged * among; count *= 2) {
      wider.find(search_, i, i + 1, count, squared_reach(options_.max_radius));
      if (!is_row(wider.of(i), i)) return true;
      if (wider.of(i).size() < count) return false;
    }
    return false;
  }

  void neighbors_of_block(std::uint32_t block, NeighborSearch::Query& query,
                          NeighborSearch::Query& wider) {
    if (block % (kStopBlock / kBlock) == 0) check_stop(options_.stop);
    std::uint32_t first = block * kBlock;
    std::uint32_t last = std::min(first + kBlock, search_.size());
    while (first < last && !asked(first)) ++first;
    while (first < last && !asked(last - 1)) --last;
    if (first == last) return;
    const std::size_t among = std::max(options_.among, options_.neighbors);
    query.find(search_, first, last, among, squared_reach(options_.max_radius));
    Voters scratch;
    for (std::uint32_t i = first; i < last; ++i) {
      if (!asked(i)) continue;
      const bool is_wider =
          query.of(i).size() == among && is_row(query.of(i), i) && look_beside_row(i, among, wider);
      const NeighborSearch::Query& found = is_wider ? wider : query;
      double farthest = 0.0;
      for (const double squared : found.squared_of(i)) farthest = std::max(farthest, squared);
      const auto chosen = voters(found.of(i), found.squared_of(i), scratch);
      if (chosen.size() < found.of(i).size())
        farthest *= static_cast<double>(chosen.size()) / static_cast<double>(found.of(i).size());
      radius_[i] = std::sqrt(farthest);
      std::uint32_t* const row = neighbors_.get() + i * options_.neighbors;
      for (const std::uint32_t n : chosen)
        if (!is_zero(normals_[n])) row[counts_[i]++] = n;
    }
  }

  /// Of one cell: its edges, and what they join.
  struct Joining {
    std::vector<Edge> confident, weak;
    Signs signs;
    std::vector<Signs::Root> roots;  ///< of the cell's points, by confident edges
  };

  void form_patches() {
    tbb::enumerable_thread_specific<Joining> of_thread;
    tbb::parallel_for(std::size_t{0}, cells_.cells.size(), [&](std::size_t c) {
      // A cell holds hundreds of points.
      check_stop(options_.stop);
      if (state_[c] != kDone) return;
      Joining& joining = of_thread.local();
      list_edges(static_cast<std::uint32_t>(c), joining);
      join_confident(cells_.cells[c], joining);
      join_unanimous(cells_.cells[c], joining);
    });
  }

  std::span<const std::uint32_t> members(const Cell& cell) const {
    return std::span(cells_.members).subspan(cell.begin, cell.end - cell.begin);
  }

  /// Votes among the points of a cell, in no order.
  void list_edges(std::uint32_t c, Joining& joining) const {
    const std::span<const std::uint32_t> points = members(cells_.cells[c]);
    // Cells that are not finer than the canonical order hold a run of points.
    const bool run = points.back() - points.front() + 1 == points.size();
    joining.confident.clear();
    joining.weak.clear();
    for (std::uint32_t a = 0; a < points.size(); ++a) {
      const std::uint32_t p = points[a];
      for (const std::uint32_t q : neighbors(p)) {
        if (cells_.cell_of[q] != c) continue;
        const auto b =
            run ? q - points.front()
                : static_cast<std::uint32_t>(std::lower_bound(points.begin(), points.end(), q) -
                                             points.begin());
        const double votes = vote(normals_[p], normals_[q], positions_[q] - positions_[p]);
        std::vector<Edge>& edges = std::abs(votes) < kConfident ? joining.weak : joining.confident;
        edges.push_back({std::min(a, b), std::max(a, b), votes});
      }
    }
  }

  /// Maximum spanning forest of the confident edges: Kruskal, On the Shortest Spanning Subtree of a
  /// Graph, 1956. Where these agree with one another, as nearly everywhere, all forests turn the
  /// points alike, and the edges need not be sorted.
  void join_confident(const Cell& cell, Joining& joining) {
    const std::span<const std::uint32_t> points = members(cell);
    Signs& signs = joining.signs;
    const auto join_all = [&] {
      signs.reset(static_cast<std::uint32_t>(points.size()));
      bool agree = true;
      for (const Edge& e : joining.confident) agree &= signs.join(e.a, e.b, e.votes < 0.0);
      return agree;
    };
    if (!join_all()) {
      sort_by_votes(joining.confident);
      join_all();
    }
    std::vector<Signs::Root>& roots = joining.roots;
    roots.resize(points.size());
    for (std::uint32_t a = 0; a < points.size(); ++a) {
      roots[a] = signs.find(a);
      first_[points[a]] = points[roots[a].member];
      turn_[points[a]] = static_cast<std::uint8_t>(roots[a].turn);
    }
  }

  void join_unanimous(const Cell& cell, Joining& joining) {
    const std::span<const std::uint32_t> points = members(cell);
    const std::vector<Signs::Root>& roots = joining.roots;
    std::vector<std::uint32_t> row(points.size()), pieces;
    for (std::uint32_t a = 0; a < points.size(); ++a) {
      if (roots[a].member != a) continue;
      row[a] = static_cast<std::uint32_t>(pieces.size());
      pieces.push_back(a);
    }
    if (pieces.size() == 1) return;
    std::vector<SignedEdge> between;
    for (const Edge& e : joining.weak) {
      const Signs::Root a = roots[e.a], b = roots[e.b];
      // The ends of confident edges are joined already.
      if (a.member == b.member) continue;
      const double votes = a.turn == b.turn ? e.votes : -e.votes;
      between.push_back({row[a.member], row[b.member], votes, std::abs(votes)});
    }
    const SignedParts parts = join_by_votes(static_cast<std::uint32_t>(pieces.size()),
                                            std::move(between), {.least_share = kUnanimous});
    for (std::uint32_t a = 0; a < points.size(); ++a) {
      const std::uint32_t piece = row[roots[a].member];
      first_[points[a]] = points[pieces[parts.part[piece]]];
      turn_[points[a]] ^= parts.turn[piece];
    }
  }

  Vec3 turned_normal(std::uint32_t i) const { return turn_[i] ? -normals_[i] : normals_[i]; }

  /// The disc that holds as many points as there are neighbours, shared among them.
  double area(std::uint32_t i) const {
    const std::size_t count = neighbors(i).size();
    return count == 0 ? 0.0
                      : std::numbers::pi * radius_[i] * radius_[i] / static_cast<double>(count);
  }

  /// Of one cell: its patches that begin among the own points, in the order of their first points,
  /// and the votes of each by the patches that they are for.
  struct CellPatches {
    std::vector<PatchSum> sums;
    std::vector<std::vector<PatchVote>> votes;
  };

  OrientedPatches result(const std::vector<std::uint8_t>& own) const {
    check_loops_are_whole();
    OrientedPatches out;
    out.patch_of.resize(end_ - begin_);
    out.turn.resize(end_ - begin_);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(begin_, end_, 4096),
                      [&](const auto& range) {
                        for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
                          const bool none = is_zero(normals_[i]);
                          out.patch_of[i - begin_] = none ? global_[i] : global_[first_[i]];
                          out.turn[i - begin_] = none ? 0 : turn_[i];
                        }
                      });
    std::vector<CellPatches> of_cell(cells_.cells.size());
    std::vector<std::uint32_t> row_of(end_ - begin_, kNobody);  // in its cell, by a patch's first
    for_each_whole(of_cell.size(), [&](std::size_t c) {
      check_stop(options_.stop);
      if (own[c] == kDone) sum_up(cells_.cells[c], row_of, of_cell[c]);
    });
    for (std::uint32_t i = begin_; i < end_; ++i) {
      const std::uint32_t row = row_of[i - begin_];
      if (row == kNobody) continue;
      const CellPatches& patches = of_cell[cells_.cell_of[i]];
      out.sums.push_back(patches.sums[row]);
      out.votes.insert(out.votes.end(), patches.votes[row].begin(), patches.votes[row].end());
    }
    return out;
  }

  void sum_up(const Cell& cell, std::vector<std::uint32_t>& row_of, CellPatches& patches) const {
    for (const std::uint32_t i : members(cell)) {
      const std::uint32_t first = first_[i];
      if (is_zero(normals_[i]) || first < begin_ || first >= end_) continue;
      std::uint32_t& row = row_of[first - begin_];
      if (row == kNobody) {
        row = static_cast<std::uint32_t>(patches.sums.size());
        PatchSum sum;
        sum.patch = global_[first];
        sum.lowest = sum.highest = positions_[i];
        sum.flux_origin = options_.cell * cell.corner;
        patches.sums.push_back(sum);
        patches.votes.emplace_back();
      }
      add(patches.sums[row], i);
      for (const std::uint32_t q : neighbors(i))
        if (first_[q] != first) add(patches.votes[row], patches.sums[row].patch, i, q);
    }
  }

  void add(PatchSum& sum, std::uint32_t i) const {
    const Vec3 p = positions_[i];
    const double of_point = area(i);
    const Vec3 n = of_point * turned_normal(i);
    ++sum.points;
    for (int axis = 0; axis < 3; ++axis) {
      sum.lowest[axis] = std::min(sum.lowest[axis], p[axis]);
      sum.highest[axis] = std::max(sum.highest[axis], p[axis]);
    }
    sum.area_normal = sum.area_normal + n;
    sum.area += of_point;
    sum.flux += dot(n, p - sum.flux_origin);
  }

  void add(std::vector<PatchVote>& votes, PatchId from, std::uint32_t p, std::uint32_t q) const {
    const double v = vote(turned_normal(p), turned_normal(q), positions_[q] - positions_[p]);
    const PatchId to = global_[first_[q]];
    auto sum = std::lower_bound(votes.begin(), votes.end(), to,
                                [](const PatchVote& x, PatchId patch) { return x.to < patch; });
    if (sum == votes.end() || sum->to != to) {
      PatchVote fresh;
      fresh.from = from;
      fresh.to = to;
      sum = votes.insert(sum, fresh);
    }
    sum->votes += v;
    sum->weight += std::abs(v);
  }

  std::span<const Vec3> positions_, normals_;
  std::span<const std::uint64_t> global_;
  std::uint32_t begin_, end_;
  OrientationOptions options_;
  Cells cells_;
  NeighborSearch search_;
  std::vector<std::uint8_t> state_;             // of cells
  std::unique_ptr<std::uint32_t[]> neighbors_;  ///< rows, of which each thread writes its own first
  std::vector<std::uint32_t> counts_;
  std::vector<double> radius_;        // of the disc that holds as many points as vote
  std::vector<std::uint32_t> first_;  // first point of a point's patch
  std::vector<std::uint8_t> turn_;
};

}  // namespace

double orientation_halo(const OrientationOptions& options) {
  // An owned point's cell, the reach of its votes, the cell voted for, the reach of its points.
  return 2.0 * (options.cell + options.max_radius);
}

OrientedPatches orient_patches(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::span<const std::uint64_t> global, std::uint32_t begin,
                               std::uint32_t end, const OrientationOptions& options) {
  return Patches(positions, normals, global, begin, end, options).run();
}

}  // namespace orbweave
