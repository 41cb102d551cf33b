#include "engine/ball_pivoting/fan_table.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <optional>

#include "engine/ball_pivoting/crowd_tree.h"
#include "engine/ball_pivoting/scratch_space.h"

namespace orbweave {
namespace {

using Points = tbb::blocked_range<std::uint32_t>;

constexpr std::uint32_t kBlockPoints = 4096;
/// From how many candidates on the neighbours are looked for in groups, and how many points of one
/// cell make it worth while to put points in groups.
constexpr std::uint32_t kCrowd = 4096, kCrowdedCell = 1024;
/// Candidates between two looks at the request to stop: a thousand points of a usual cloud, a few
/// of a spot that is far denser than the balls are wide.
constexpr std::uint64_t kLookEvery = std::uint64_t{1} << 16;

/// First cells of blocks of about kBlockPoints points, and the end.
std::vector<std::uint32_t> cut_into_blocks(const CellGrid& grid) {
  std::vector<std::uint32_t> firsts;
  std::uint32_t next = 0;
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell) {
    if (grid.cell_begin(cell) < next) continue;
    firsts.push_back(cell);
    next = grid.cell_begin(cell) + kBlockPoints;
  }
  firsts.push_back(grid.cells());
  return firsts;
}

/// Activity by sorted index; empty when everybody is active.
std::vector<std::uint8_t> sorted_activity(const CellGrid& grid,
                                          std::span<const std::uint8_t> active) {
  std::vector<std::uint8_t> sorted;
  if (active.empty()) return sorted;
  sorted.resize(grid.size());
  tbb::parallel_for(Points(0, grid.size(), kBlockPoints), [&](const Points& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i)
      sorted[i] = active[grid.original(i)];
  });
  return sorted;
}

/// Whether to walk among the nearest neighbours first, by how often that has settled fans of late.
/// It decides about time, never about what is found.
class NearestFirst {
 public:
  bool is_worth_it() { return share_ > kWorthwhile || ++passed_over_ % kTryAgain == 0; }
  void learn(std::uint32_t settled, std::uint32_t walks) {
    if (walks == 0) return;
    share_ += (static_cast<double>(settled) / walks - share_) * kWeightOfLatest;
  }

 private:
  /// The share of settled fans at which the time saved and the time lost are equal.
  static constexpr double kWorthwhile = 0.5;
  static constexpr double kWeightOfLatest = 0.125;
  static constexpr std::uint32_t kTryAgain = 16;
  double share_ = 1.0;
  std::uint32_t passed_over_ = 0;
};

/// Corners of the triangles that there are at the points of a grid of some points.
class TakenCorners {
 public:
  /// `among`: points of `grid`; `taken`: by the indices that `grid` was made of, sorted.
  TakenCorners(const CellGrid& grid, const CellGrid& among, std::span<const VertexCorner> taken)
      : taken_(taken) {
    if (taken.empty()) return;
    begin_.assign(among.size(), 0);
    vertex_.resize(among.size());
    place_.assign(grid.size(), kNone);
    tbb::parallel_for(Points(0, among.size(), kBlockPoints), [&](const Points& range) {
      for (std::uint32_t i = range.begin(); i < range.end(); ++i) {
        vertex_[i] = grid.original(among.original(i));
        place_[vertex_[i]] = i;
      }
    });
    using Corners = tbb::blocked_range<std::size_t>;
    tbb::parallel_for(Corners(0, taken.size(), kBlockPoints), [&](const Corners& range) {
      for (std::size_t c = range.begin(); c < range.end(); ++c) {
        if (c > 0 && taken[c].vertex == taken[c - 1].vertex) continue;
        const std::uint32_t place = place_[taken[c].vertex];
        if (place != kNone) begin_[place] = c;
      }
    });
  }

  /// The corners at a point of `among`, by indices there; kNone: a neighbour that is not there.
  void list(std::uint32_t point, std::vector<Corner>& corners) const {
    corners.clear();
    if (taken_.empty()) return;
    for (std::size_t c = begin_[point]; c < taken_.size() && taken_[c].vertex == vertex_[point];
         ++c)
      corners.push_back(
          make_corner(place_[first_of(taken_[c].corner)], place_[second_of(taken_[c].corner)]));
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffffu;
  std::span<const VertexCorner> taken_;
  std::vector<std::size_t> begin_;     // per point of `among`: its first corner, if there is one
  std::vector<std::uint32_t> vertex_;  // per point of `among`
  std::vector<std::uint32_t> place_;   // in `among`
};

/// Walks at the points of one block of cells; fans come out in sorted order.
class BlockWalk {
 public:
  /// `groups`: of the grid's points; null where nothing is crowded. `active`: null, or of all
  /// points; then triangles are looked for at the first of their vertices, with the edges that
  /// `taken` leaves.
  BlockWalk(const CellGrid& grid, const GroupedPoints* groups, double ball_radius,
            const std::uint8_t* active, WalkKernel kernel, const StopToken* stop,
            const TakenCorners* taken = nullptr)
      : grid_(grid),
        groups_(groups),
        ball_radius_(ball_radius),
        active_(active),
        kernel_(kernel),
        looks_(stop, kLookEvery),
        taken_(taken) {}

  /// take(sorted index, fan) is called for every point of cells [first, last) that was walked at.
  template <class Take>
  void run(std::uint32_t first, std::uint32_t last, const Take& take) {
    CellGrid::Cursor cursor(grid_, first);
    for (std::uint32_t cell = first; cell < last; ++cell) {
      const std::uint32_t begin = grid_.cell_begin(cell), end = grid_.cell_end(cell);
      const CandidateRanges candidates = cursor.around(cell);
      const bool crowded = groups_ != nullptr && candidates.size() >= kCrowd;
      make_room(crowded ? kMostOfCrowd : candidates.size(), take);
      for (std::uint32_t i = begin; i < end; ++i) {
        if (!crowded || !gather_crowd(i)) {
          make_room(candidates.size(), take);
          looks_.after(candidates.size());
          WalkScratch& scratch = space_.arrays()[gathered_];
          scratch.point = i;
          kernel_.gather(grid_.arrays(), candidates, ball_radius_, scratch);
        }
        ++gathered_;
        if (gathered_ == kWalksAtOnce) walk_at_gathered(take);
      }
    }
    walk_at_gathered(take);
  }

 private:
  bool gather_crowd(std::uint32_t point) {
    looks_.after(kMostOfCrowd);
    WalkScratch& scratch = space_.arrays()[gathered_];
    scratch.point = point;
    return kernel_.gather_crowd(grid_.arrays(), *groups_, ball_radius_, scratch);
  }
  template <class Take>
  void make_room(std::uint32_t candidates, const Take& take) {
    if (!space_.is_too_small(candidates)) return;
    walk_at_gathered(take);
    space_.grow(candidates);
  }
  template <class Take>
  void walk_at_gathered(const Take& take) {
    if (active_ != nullptr) {
      for (std::uint32_t w = 0; w < gathered_; ++w) {
        taken_->list(space_.arrays()[w].point, taken_list_);
        kernel_.suspect(grid_.arrays(), space_.arrays()[w], active_, taken_list_.data(),
                        static_cast<std::uint32_t>(taken_list_.size()), space_.fans()[w]);
        take(space_.arrays()[w].point, space_.fans()[w]);
      }
      gathered_ = 0;
      return;
    }
    const bool nearest_first = nearest_first_.is_worth_it();
    const std::uint32_t settled =
        kernel_.walk(grid_.arrays(), space_.arrays(), gathered_, nearest_first, space_.fans());
    if (nearest_first) nearest_first_.learn(settled, gathered_);
    for (std::uint32_t w = 0; w < gathered_; ++w) {
      take(space_.arrays()[w].point, space_.fans()[w]);
    }
    gathered_ = 0;
  }

  const CellGrid& grid_;
  const GroupedPoints* const groups_;
  const double ball_radius_;
  const std::uint8_t* active_;
  const WalkKernel kernel_;
  StopLooks looks_;
  const TakenCorners* const taken_;
  std::vector<Corner> taken_list_;
  ScratchSpace space_;
  NearestFirst nearest_first_;
  std::uint32_t gathered_ = 0;  // points of the next call
};

bool is_crowded(const CellGrid& grid) {
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell)
    if (grid.cell_end(cell) - grid.cell_begin(cell) >= kCrowdedCell) return true;
  return false;
}

/// The grid's points in groups, where any place is crowded.
class Groups {
 public:
  explicit Groups(const CellGrid& grid) {
    if (is_crowded(grid)) tree_.emplace(grid);
  }
  const GroupedPoints* get() const { return tree_ ? &tree_->groups() : nullptr; }

 private:
  std::optional<CrowdTree> tree_;
};

/// A point at which triangles were found among some points alone, and how many.
struct Suspected {
  std::uint32_t point = 0;
  std::uint32_t count = 0;
};

/// Holds triangles that were found among some points against all of them.
class BlockConfirm {
 public:
  BlockConfirm(const CellGrid& grid, const GroupedPoints* groups, double ball_radius,
               const std::uint8_t* active, WalkKernel kernel, const StopToken* stop)
      : grid_(grid),
        groups_(groups),
        ball_radius_(ball_radius),
        active_(active),
        kernel_(kernel),
        looks_(stop, kLookEvery) {}

  /// Calls take(fan) for every suspected point. Points ascend; `corners`: of one after the other.
  template <class Take>
  void run(std::span<const Suspected> suspected, std::span<const Corner> corners,
           const Take& take) {
    if (suspected.empty()) return;
    std::uint32_t cell = grid_.cell_of(suspected.front().point);
    CellGrid::Cursor cursor(grid_, cell);
    CandidateRanges candidates = cursor.around(cell);
    const Corner* at = corners.data();
    for (const Suspected& s : suspected) {
      if (s.point >= grid_.cell_end(cell)) {
        cell = grid_.cell_of(s.point);
        candidates = cursor.around(cell);
      }
      gather(s.point, candidates);
      kernel_.confirm(grid_.arrays(), space_.arrays()[0], active_, at, s.count, space_.fans()[0]);
      take(space_.fans()[0]);
      at += s.count;
    }
  }

 private:
  void gather(std::uint32_t point, const CandidateRanges& candidates) {
    const std::uint32_t size = candidates.size();
    const bool crowded = groups_ != nullptr && size >= kCrowd;
    make_room(crowded ? kMostOfCrowd : size);
    space_.arrays()[0].point = point;
    looks_.after(crowded ? kMostOfCrowd : size);
    if (crowded && kernel_.gather_crowd(grid_.arrays(), *groups_, ball_radius_, space_.arrays()[0]))
      return;
    make_room(size);
    space_.arrays()[0].point = point;
    kernel_.gather(grid_.arrays(), candidates, ball_radius_, space_.arrays()[0]);
  }
  void make_room(std::uint32_t candidates) {
    if (space_.is_too_small(candidates)) space_.grow(candidates);
  }

  const CellGrid& grid_;
  const GroupedPoints* const groups_;
  const double ball_radius_;
  const std::uint8_t* active_;
  const WalkKernel kernel_;
  StopLooks looks_;
  ScratchSpace space_;
};

}  // namespace

FanTable walk_all(const CellGrid& grid, double ball_radius, std::span<const std::uint8_t> active,
                  VectorWidth width, const StopToken* stop, std::span<const VertexCorner> taken) {
  FanTable table(grid.size());
  table.closed_.assign(grid.size(), 0);
  table.blocked_.assign(grid.size(), 0);
  const std::vector<std::uint8_t> sorted_active = sorted_activity(grid, active);
  if (!active.empty()) {
    table.walk_at_active(grid, ball_radius, sorted_active, taken, walk_kernel(width), stop);
  } else {
    table.walk_everywhere(grid, ball_radius, walk_kernel(width), stop);
  }
  return table;
}

void FanTable::walk_everywhere(const CellGrid& grid, double ball_radius, WalkKernel kernel,
                               const StopToken* stop) {
  const Groups groups(grid);
  const std::vector<std::uint32_t> firsts = cut_into_blocks(grid);
  const std::size_t blocks = firsts.size() - 1;
  blocks_.resize(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    std::vector<Corner> corners;
    const std::uint32_t begin = grid.cell_begin(firsts[block]);
    const std::uint32_t end = grid.cell_begin(firsts[block + 1]);
    corners.reserve(std::size_t{7} * (end - begin));
    std::vector<std::size_t> starts(end - begin, 0);
    BlockWalk walk(grid, groups.get(), ball_radius, nullptr, kernel, stop);
    walk.run(firsts[block], firsts[block + 1], [&](std::uint32_t i, const Fan& fan) {
      const std::uint32_t point = grid.original(i);
      starts[i - begin] = corners.size();
      count_[point] = fan.count;
      closed_[point] = fan.closed ? 1 : 0;
      blocked_[point] = fan.blocked ? 1 : 0;
      for (std::uint32_t c = 0; c < fan.count; ++c) {
        corners.push_back(make_corner(grid.original(first_of(fan.corners[c])),
                                      grid.original(second_of(fan.corners[c]))));
      }
    });
    for (std::uint32_t i = begin; i < end; ++i) {
      begin_[grid.original(i)] = corners.data() + starts[i - begin];
    }
    blocks_[block] = std::move(corners);
  });
}

/// A ball that is empty of all points is empty of the active ones, which are few: what is found
/// among these alone is all there can be, and is then held against all points.
void FanTable::walk_at_active(const CellGrid& grid, double ball_radius,
                              std::span<const std::uint8_t> active,
                              std::span<const VertexCorner> taken, WalkKernel kernel,
                              const StopToken* stop) {
  const CellGrid among(grid, active);
  const TakenCorners taken_among(grid, among, taken);
  const std::vector<std::uint8_t> everybody(among.size(), 1);
  const Groups groups_among(among), groups(grid);
  const std::vector<std::uint32_t> firsts = cut_into_blocks(among);
  const std::size_t blocks = firsts.size() - 1;
  blocks_.resize(blocks);
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t block) {
    std::vector<Suspected> suspected;
    std::vector<Corner> corners;
    BlockWalk walk(among, groups_among.get(), ball_radius, everybody.data(), kernel, stop,
                   &taken_among);
    walk.run(firsts[block], firsts[block + 1], [&](std::uint32_t i, const Fan& fan) {
      blocked_[grid.original(among.original(i))] = fan.blocked ? 1 : 0;
      if (fan.count == 0) return;
      suspected.push_back({among.original(i), fan.count});
      const auto first = static_cast<std::ptrdiff_t>(corners.size());
      for (std::uint32_t c = 0; c < fan.count; ++c) {
        corners.push_back(make_corner(among.original(first_of(fan.corners[c])),
                                      among.original(second_of(fan.corners[c]))));
      }
      std::sort(corners.begin() + first, corners.end());
    });
    std::vector<Corner> confirmed;
    std::vector<std::size_t> starts;
    BlockConfirm confirm(grid, groups.get(), ball_radius, active.data(), kernel, stop);
    confirm.run(suspected, corners, [&](const Fan& fan) {
      starts.push_back(confirmed.size());
      for (std::uint32_t c = 0; c < fan.count; ++c) {
        confirmed.push_back(make_corner(grid.original(first_of(fan.corners[c])),
                                        grid.original(second_of(fan.corners[c]))));
      }
    });
    starts.push_back(confirmed.size());
    for (std::size_t s = 0; s < suspected.size(); ++s) {
      const std::uint32_t point = grid.original(suspected[s].point);
      begin_[point] = confirmed.data() + starts[s];
      count_[point] = static_cast<std::uint32_t>(starts[s + 1] - starts[s]);
    }
    blocks_[block] = std::move(confirmed);
  });
}

}  // namespace orbweave
