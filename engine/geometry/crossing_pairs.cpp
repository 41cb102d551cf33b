#include "engine/geometry/crossing_pairs.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>

#include "engine/geometry/triangle_intersection.h"
#include "engine/geometry/unit_scale.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kGroup = 8;

/// Boxes side by side. Scaling by a power of two and rounding to float keep the order of
/// coordinates, so boxes that meet as doubles meet here, too.
struct FloatBoxes {
  std::array<std::vector<float>, 3> min, max;

  std::uint32_t size() const { return static_cast<std::uint32_t>(min[0].size()); }
  void resize(std::size_t count) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    for (std::vector<float>& list : min) list.resize(count, kInfinity);
    for (std::vector<float>& list : max) list.resize(count, -kInfinity);
  }
  void extend(std::uint32_t i, const FloatBoxes& other, std::uint32_t k) {
    for (int axis = 0; axis < 3; ++axis) {
      min[axis][i] = std::min(min[axis][i], other.min[axis][k]);
      max[axis][i] = std::max(max[axis][i], other.max[axis][k]);
    }
  }
  /// Box i of these against eight of others from `first` on: a bit each where they meet.
  std::uint32_t meeting(std::uint32_t i, const FloatBoxes& other, std::uint32_t first) const {
    // A bit each; without branches the compiler makes vectors of it.
    std::array<std::int32_t, kGroup> meets;
    for (std::uint32_t k = 0; k < kGroup; ++k) meets[k] = std::int32_t{1} << k;
    for (int axis = 0; axis < 3; ++axis) {
      const float low = min[axis][i], high = max[axis][i];
      const float* lows = other.min[axis].data() + first;
      const float* highs = other.max[axis].data() + first;
      for (std::uint32_t k = 0; k < kGroup; ++k)
        meets[k] &= -static_cast<std::int32_t>(low <= highs[k]) &
                    -static_cast<std::int32_t>(lows[k] <= high);
    }
    std::uint32_t bits = 0;
    for (std::uint32_t k = 0; k < kGroup; ++k) bits += static_cast<std::uint32_t>(meets[k]);
    return bits;
  }
};

/// A tree whose leaves are groups of triangles in their order: those that follow one another lie
/// close together.
class Search {
 public:
  Search(std::span<const Vec3> positions, std::span<const Triangle> triangles,
         const PairsWanted& wanted)
      : positions_(positions), triangles_(triangles), wanted_(wanted) {
    levels_.emplace_back();
    add_boxes_of_triangles();
    while (levels_.back().size() > kGroup || levels_.size() < 2) add_level();
    looks_.assign((triangles_.size() + kGroup - 1) / kGroup, wanted.mark.empty() ? 1 : 0);
    for (std::size_t t = 0; t < wanted.mark.size(); ++t)
      if (wanted.mark[t] != 0) looks_[t / kGroup] = 1;
  }

  std::uint32_t groups() const { return static_cast<std::uint32_t>(looks_.size()); }

  /// The pairs that are found from a group: with itself, with later ones, and with those that do
  /// not look themselves.
  void pairs_of(std::uint32_t group, std::vector<TrianglePair>& pairs) const {
    if (looks_[group] == 0) return;
    descend(group, static_cast<std::uint32_t>(levels_.size() - 1), 0, pairs);
  }

 private:
  static std::size_t whole_groups(std::size_t count) {
    return (count + kGroup - 1) / kGroup * kGroup;
  }

  /// What takes the coordinates, counted from an origin, into the range of floats.
  double scale_from(Vec3 origin) const {
    double farthest = 0.0;
    for (const Triangle& triangle : triangles_) {
      for (const std::uint32_t v : triangle) {
        const Vec3 p = positions_[v] - origin;
        farthest = std::max({farthest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      }
    }
    return unit_scale(farthest);
  }

  void add_boxes_of_triangles() {
    FloatBoxes& boxes = levels_.front();
    boxes.resize(whole_groups(triangles_.size()));
    const Vec3 origin = triangles_.empty() ? Vec3{} : positions_[triangles_.front()[0]];
    const double scale = scale_from(origin);
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      for (const std::uint32_t v : triangles_[t]) {
        const Vec3 p = scale * (positions_[v] - origin);
        for (int axis = 0; axis < 3; ++axis) {
          const auto at = static_cast<float>(p[axis]);
          boxes.min[axis][t] = std::min(boxes.min[axis][t], at);
          boxes.max[axis][t] = std::max(boxes.max[axis][t], at);
        }
      }
    }
  }

  void add_level() {
    FloatBoxes above;
    const FloatBoxes& below = levels_.back();
    above.resize(whole_groups(below.size() / kGroup));
    for (std::uint32_t i = 0; i < below.size(); ++i) above.extend(i / kGroup, below, i);
    levels_.push_back(std::move(above));
  }

  /// Visits the groups below eight entries of a level.
  void descend(std::uint32_t group, std::uint32_t level, std::uint32_t first,
               std::vector<TrianglePair>& pairs) const {
    for (std::uint32_t bits = levels_[1].meeting(group, levels_[level], first); bits != 0;
         bits &= bits - 1) {
      const std::uint32_t entry = first + static_cast<std::uint32_t>(std::countr_zero(bits));
      if (level > 1)
        descend(group, level - 1, entry * kGroup, pairs);
      else if (entry >= group || looks_[entry] == 0)
        compare(group, entry, pairs);
    }
  }

  bool is_wanted(std::uint32_t i, std::uint32_t j) const {
    return std::min(i, j) < wanted_.first_below &&
           (wanted_.mark.empty() || wanted_.mark[i] != 0 || wanted_.mark[j] != 0);
  }

  void compare(std::uint32_t group, std::uint32_t other, std::vector<TrianglePair>& pairs) const {
    const FloatBoxes& boxes = levels_.front();
    for (std::uint32_t own = levels_[1].meeting(other, boxes, group * kGroup); own != 0;
         own &= own - 1) {
      const std::uint32_t i = group * kGroup + static_cast<std::uint32_t>(std::countr_zero(own));
      for (std::uint32_t bits = boxes.meeting(i, boxes, other * kGroup); bits != 0;
           bits &= bits - 1) {
        const std::uint32_t j = other * kGroup + static_cast<std::uint32_t>(std::countr_zero(bits));
        const bool is_seen_before = other == group && j <= i;
        if (!is_seen_before && is_wanted(i, j) &&
            triangles_intersect(positions_, triangles_[i], triangles_[j]))
          pairs.push_back({std::min(i, j), std::max(i, j)});
      }
    }
  }

  std::span<const Vec3> positions_;
  std::span<const Triangle> triangles_;
  PairsWanted wanted_;
  std::vector<std::uint8_t> looks_;  // per group: some triangle is marked
  std::vector<FloatBoxes> levels_;   // triangles, groups of them, groups of those, ...
};

}  // namespace

std::vector<TrianglePair> crossing_pairs(std::span<const Vec3> positions,
                                         std::span<const Triangle> triangles,
                                         const StopToken* stop) {
  return crossing_pairs(positions, triangles, PairsWanted{}, stop);
}

std::vector<TrianglePair> crossing_pairs(std::span<const Vec3> positions,
                                         std::span<const Triangle> triangles,
                                         const PairsWanted& wanted, const StopToken* stop) {
  if (triangles.empty()) return {};
  const Search search(positions, triangles, wanted);
  constexpr std::uint32_t kBlock = 512;  // groups
  std::vector<std::vector<TrianglePair>> blocks((search.groups() + kBlock - 1) / kBlock);
  const auto search_block = [&](std::size_t b) {
    check_stop(stop);
    const auto first = static_cast<std::uint32_t>(b) * kBlock;
    const std::uint32_t last = std::min(first + kBlock, search.groups());
    for (std::uint32_t group = first; group < last; ++group) search.pairs_of(group, blocks[b]);
  };
  // A thread that waits here must not begin another chunk, whose memory is not free yet.
  tbb::this_task_arena::isolate(
      [&] { tbb::parallel_for(std::size_t{0}, blocks.size(), search_block); });
  std::vector<TrianglePair> pairs;
  for (const std::vector<TrianglePair>& block : blocks)
    pairs.insert(pairs.end(), block.begin(), block.end());
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace orbweave
