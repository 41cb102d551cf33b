#include "engine/geometry/neighbor_search.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace orbweave {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();
/// More than rounding adds to a squared sum of two distances.
constexpr double kRoundingMargin = 1e-12;
using Range = tbb::blocked_range<std::size_t>;

bool nearer(const Neighbor& a, const Neighbor& b) {
  return a.squared_distance < b.squared_distance ||
         (a.squared_distance == b.squared_distance && a.index < b.index);
}

/// How far apart two intervals are. Rounding keeps the order: never more than the computed
/// distance of two members.
double gap(double low_a, double high_a, double low_b, double high_b) {
  const double above = low_a - high_b, below = low_b - high_a;
  const double apart = above > below ? above : below;
  return apart > 0.0 ? apart : 0.0;
}

double squared_gap(Vec3 low_a, Vec3 high_a, Vec3 low_b, Vec3 high_b) {
  const Vec3 apart{gap(low_a.x, high_a.x, low_b.x, high_b.x),
                   gap(low_a.y, high_a.y, low_b.y, high_b.y),
                   gap(low_a.z, high_a.z, low_b.z, high_b.z)};
  return squared_norm(apart);
}

Vec3 lower(Vec3 a, Vec3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 upper(Vec3 a, Vec3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

}  // namespace

NeighborSearch::NeighborSearch(std::span<const Vec3> positions)
    : size_(static_cast<std::uint32_t>(positions.size())) {
  const std::size_t blocks = (positions.size() + kBlock - 1) / kBlock;
  for (std::vector<double>* axis : {&x_, &y_, &z_}) axis->assign(blocks * kBlock, 0.0);
  if (blocks == 0) return;
  levels_.emplace_back(blocks);
  tbb::parallel_for(Range(0, blocks, 1024), [&](const Range& r) {
    for (std::size_t b = r.begin(); b < r.end(); ++b) {
      const std::size_t begin = b * kBlock;
      const std::size_t end = std::min<std::size_t>(begin + kBlock, positions.size());
      Bounds box{positions[begin], positions[begin]};
      for (std::size_t i = begin; i < end; ++i) {
        x_[i] = positions[i].x;
        y_[i] = positions[i].y;
        z_[i] = positions[i].z;
        box = {lower(box.low, positions[i]), upper(box.high, positions[i])};
      }
      levels_[0][b] = box;
    }
  });
  while (levels_.back().size() > 1) {
    const std::vector<Bounds>& below = levels_.back();
    std::vector<Bounds> above((below.size() + kFan - 1) / kFan);
    for (std::size_t i = 0; i < below.size(); ++i) {
      Bounds& box = above[i / kFan];
      if (i % kFan == 0) box = below[i];
      box = {lower(box.low, below[i].low), upper(box.high, below[i].high)};
    }
    levels_.push_back(std::move(above));
  }
}

void NeighborSearch::Query::enter(std::size_t row, Neighbor candidate) {
  Neighbor* first = found_.data() + row * stride_;
  // The last slot holds the limit until a neighbour takes it, or is the one to be pushed out.
  std::size_t& count = found_count_[row];
  std::size_t at = count == stride_ ? count - 1 : count++;
  for (; at > 0 && nearer(candidate, first[at - 1]); --at) first[at] = first[at - 1];
  first[at] = candidate;
}

/// As many points as asked for lie within the previous point's limit of it: no farther from this
/// point than that and the distance of both. Saves most of the entries that others push out again.
void NeighborSearch::Query::bound_by_previous(const NeighborSearch& search, std::uint32_t i) {
  const std::size_t row = i - begin_;
  if (found_count_[row - 1] < stride_) return;
  const Vec3 step{search.x_[i] - search.x_[i - 1], search.y_[i] - search.y_[i - 1],
                  search.z_[i] - search.z_[i - 1]};
  const double reach = std::sqrt(worst(row - 1)) + norm(step);
  const double limit = reach * reach * (1.0 + kRoundingMargin);
  if (limit < worst(row)) found_[row * stride_ + stride_ - 1] = {limit, kNobody};
}

void NeighborSearch::Query::scan(const NeighborSearch& search, std::uint32_t block) {
  const std::uint32_t first = block * kBlock;
  const std::uint32_t last = std::min(first + kBlock, search.size_);
  const Bounds& box = search.levels_[0][block];
  NearInBlock near;
  farthest_ = 0.0;
  for (std::uint32_t i = begin_; i < end_; ++i) {
    const std::size_t row = i - begin_;
    const double x = search.x_[i], y = search.y_[i], z = search.z_[i];
    if (!bounded_ && row > 0) bound_by_previous(search, i);
    if (squared_gap(box.low, box.high, {x, y, z}, {x, y, z}) <= worst(row)) {
      scan_block_(search.x_.data() + first, search.y_.data() + first, search.z_.data() + first, x,
                  y, z, worst(row), near);
      for (std::uint32_t l = 0; l < near.count && near.listed[l] < last - first; ++l) {
        const std::uint32_t j = near.listed[l];
        const Neighbor candidate{near.squared[j], first + j};
        if (first + j != i && nearer(candidate, found_[row * stride_ + stride_ - 1]))
          enter(row, candidate);
      }
    }
    farthest_ = std::max(farthest_, worst(row));
  }
}

void NeighborSearch::Query::descend(const NeighborSearch& search, std::size_t level,
                                    std::uint32_t node) {
  if (level == 0) {
    if (node != begin_ / kBlock) scan(search, node);
    return;
  }
  struct Child {
    double distance;
    std::uint32_t node;
  } children[kFan];
  const std::vector<Bounds>& boxes = search.levels_[level - 1];
  const std::uint32_t first = node * kFan;
  const std::uint32_t last = std::min(first + kFan, static_cast<std::uint32_t>(boxes.size()));
  std::uint32_t count = 0;
  for (std::uint32_t c = first; c < last; ++c) {
    const double distance = squared_gap(boxes[c].low, boxes[c].high, low_, high_);
    if (!(distance <= farthest_)) continue;
    std::uint32_t at = count++;
    for (; at > 0 && distance < children[at - 1].distance; --at) children[at] = children[at - 1];
    children[at] = {distance, c};
  }
  for (std::uint32_t c = 0; c < count && children[c].distance <= farthest_; ++c)
    descend(search, level - 1, children[c].node);
}

void NeighborSearch::Query::find(const NeighborSearch& search, std::uint32_t begin,
                                 std::uint32_t end, std::size_t count, double max_squared) {
  begin_ = begin;
  end_ = end;
  stride_ = std::min<std::size_t>(count, search.size_);
  found_.assign((end - begin) * stride_, {max_squared, kNobody});
  found_count_.assign(end - begin, 0);
  bounded_ = false;
  if (stride_ == 0 || begin == end) return;
  low_ = {kInfinity, kInfinity, kInfinity};
  high_ = -low_;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Vec3 p{search.x_[i], search.y_[i], search.z_[i]};
    low_ = lower(low_, p);
    high_ = upper(high_, p);
  }
  scan(search, begin / kBlock);
  bounded_ = true;
  descend(search, search.levels_.size() - 1, 0);
}

}  // namespace orbweave
