#include "engine/geometry/neighbor_search.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace orbweave {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
/// Of a squared distance at which too few points were found, the first time.
constexpr double kGrowth = 2.0;
/// Of what a block lets expect: most points need no more.
constexpr double kMargin = 1.3;
/// Expected distances that the last block's may exceed this many times.
constexpr double kTrusted = 3.0;
/// More than rounding adds to a squared sum of two distances.
constexpr double kRoundingMargin = 1e-12;
using Range = tbb::blocked_range<std::size_t>;

Vec3 lower(Vec3 a, Vec3 b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 upper(Vec3 a, Vec3 b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

/// Squared distance, about, of the last of `count` neighbours among the points of a block: those of
/// a surface, or of a row.
double expected_reach(Vec3 extent, double count) {
  const double least = std::min({extent.x, extent.y, extent.z});
  const double longest = std::max({extent.x, extent.y, extent.z});
  const double middle = extent.x + extent.y + extent.z - least - longest;
  constexpr double kPoints = NeighborSearch::kBlock;
  const double along = longest * count / (2.0 * kPoints);
  return std::max(longest * middle * count / (kPoints * std::numbers::pi), along * along);
}

}  // namespace

NeighborSearch::NeighborSearch(std::span<const Vec3> positions)
    : size_(static_cast<std::uint32_t>(positions.size())) {
  const std::size_t blocks = (positions.size() + kBlock - 1) / kBlock;
  for (std::vector<double>* axis : {&x_, &y_, &z_}) axis->assign(blocks * kBlock, kNotANumber);
  for (std::vector<double>& column : bounds_)
    column.assign(blocks * kPartsPerBlock + kMostLanes, kInfinity);
  if (blocks == 0) return;
  levels_.emplace_back(blocks);
  tbb::parallel_for(Range(0, blocks, 1024), [&](const Range& r) {
    for (std::size_t b = r.begin(); b < r.end(); ++b) levels_[0].set(b, fill_block(positions, b));
  });
  while (levels_.back().size > 1) {
    const Boxes& below = levels_.back();
    Boxes above((below.size + kFan - 1) / kFan);
    for (std::size_t parent = 0; parent < above.size; ++parent) {
      const std::size_t first = parent * kFan;
      Bounds box = below.at(first);
      for (std::size_t i = first + 1; i < std::min(first + kFan, below.size); ++i)
        box = {lower(box.low, below.at(i).low), upper(box.high, below.at(i).high)};
      above.set(parent, box);
    }
    levels_.push_back(std::move(above));
  }
}

NeighborSearch::Boxes::Boxes(std::size_t count) : size(count) {
  for (std::vector<double>& column : columns) column.assign(count + kMostLanes, kInfinity);
}

void NeighborSearch::Boxes::set(std::size_t box, const Bounds& bounds) {
  for (int axis = 0; axis < 3; ++axis) {
    columns[axis][box] = bounds.low[axis];
    columns[axis + 3][box] = bounds.high[axis];
  }
}

NeighborSearch::Bounds NeighborSearch::Boxes::at(std::size_t box) const {
  return {{columns[0][box], columns[1][box], columns[2][box]},
          {columns[3][box], columns[4][box], columns[5][box]}};
}

/// A part without points is infinitely far away.
NeighborSearch::Bounds NeighborSearch::fill_block(std::span<const Vec3> positions,
                                                  std::size_t block) {
  constexpr std::size_t kPart = kBlock / kPartsPerBlock;
  const std::size_t begin = block * kBlock;
  const std::size_t end = std::min<std::size_t>(begin + kBlock, positions.size());
  Bounds whole{positions[begin], positions[begin]};
  for (std::size_t first = begin; first < end; first += kPart) {
    Bounds box{positions[first], positions[first]};
    for (std::size_t i = first; i < std::min(first + kPart, end); ++i) {
      x_[i] = positions[i].x;
      y_[i] = positions[i].y;
      z_[i] = positions[i].z;
      box = {lower(box.low, positions[i]), upper(box.high, positions[i])};
    }
    for (int axis = 0; axis < 3; ++axis) {
      bounds_[axis][first / kPart] = box.low[axis];
      bounds_[axis + 3][first / kPart] = box.high[axis];
    }
    whole = {lower(whole.low, box.low), upper(whole.high, box.high)};
  }
  return whole;
}

PositionColumns NeighborSearch::columns() const {
  PositionColumns columns{x_.data(), y_.data(), z_.data(), {}};
  for (int column = 0; column < 6; ++column) columns.bounds[column] = bounds_[column].data();
  return columns;
}

/// Collects the blocks below a node, which is within reach itself, that are within reach.
void NeighborSearch::Query::descend(const NeighborSearch& search, std::size_t level,
                                    std::uint32_t node, double reach) {
  if (level == 0) {
    const Boxes& boxes = search.levels_[level];
    block_.push_back(node);
    for (int column = 0; column < 6; ++column)
      bounds_[column].push_back(boxes.columns[column][node]);
    return;
  }
  const Boxes& children = search.levels_[level - 1];
  const std::size_t first = std::size_t{node} * kFan;
  const double* columns[6];
  for (int column = 0; column < 6; ++column) columns[column] = children.columns[column].data();
  unsigned near = kernel_.near_boxes(columns, first, &low_.x, &high_.x, reach);
  if (children.size - first < kFan) near &= (1u << (children.size - first)) - 1u;
  for (; near != 0; near &= near - 1)
    descend(search, level - 1, static_cast<std::uint32_t>(first) + std::countr_zero(near), reach);
}

/// The blocks that any of the query points may need.
void NeighborSearch::Query::collect(const NeighborSearch& search, double reach) {
  reach_ = reach;
  block_.clear();
  for (std::vector<double>& column : bounds_) column.clear();
  descend(search, search.levels_.size() - 1, 0, reach);
  for (std::vector<double>& column : bounds_) column.resize(block_.size() + kMostLanes);
  const std::size_t points = block_.size() * kBlock;
  if (near_index_.size() >= points + kMostLanes) return;
  near_squared_.resize(2 * (points + kMostLanes));
  near_index_.resize(points + kMostLanes);
}

BlockColumns NeighborSearch::Query::blocks() const {
  BlockColumns blocks;
  for (int column = 0; column < 6; ++column) blocks.bounds[column] = bounds_[column].data();
  blocks.block = block_.data();
  blocks.count = static_cast<std::uint32_t>(block_.size());
  return blocks;
}

void NeighborSearch::Query::find_row(const NeighborSearch& search, std::uint32_t index,
                                     double max_squared) {
  const Vec3 place{search.x_[index], search.y_[index], search.z_[index]};
  // As many points as asked for lie within the previous point's limit of it: no farther from this
  // point than that and the distance of both.
  double sure = max_squared;
  if (row_limit_ >= 0.0) {
    const Vec3 before{search.x_[row_before_], search.y_[row_before_], search.z_[row_before_]};
    const double reach = std::sqrt(row_limit_) + norm(place - before);
    sure = std::min(sure, reach * reach * (1.0 + kRoundingMargin));
  }
  double limit = std::min(sure, start_);
  std::uint32_t count = 0;
  for (double growth = kGrowth;; growth *= growth) {
    count = kernel_.gather(search.columns(), blocks(), &place.x, index, limit,
                           {near_squared_.data(), near_index_.data()});
    if (count >= stride_ || !(limit < sure)) break;
    limit = growth * limit > limit ? std::min(sure, growth * limit) : sure;
    if (limit > reach_) collect(search, std::min(sure, kGrowth * limit));
  }
  const FoundColumns to{found_squared_.data() + row_begin(index),
                        found_index_.data() + row_begin(index)};
  const FoundColumns from{near_squared_.data(), near_index_.data()};
  if (count > stride_) {
    row_limit_ = kernel_.select(from, count, static_cast<std::uint32_t>(stride_), to);
  } else {
    std::copy_n(from.squared, count, to.squared);
    std::copy_n(from.index, count, to.index);
    row_limit_ = count == stride_ ? limit : -1.0;
  }
  row_before_ = index;
  start_ = std::max(start_, row_limit_);
  found_count_[index - begin_] = std::min<std::size_t>(count, stride_);
  farthest_ = std::max(farthest_, row_limit_ >= 0.0 ? row_limit_ : max_squared);
}

void NeighborSearch::Query::find(const NeighborSearch& search, std::uint32_t begin,
                                 std::uint32_t end, std::size_t count, double max_squared,
                                 std::span<const std::uint8_t> asked) {
  begin_ = begin;
  end_ = end;
  stride_ = std::min<std::size_t>(count, search.size_);
  found_squared_.resize((end - begin) * stride_ + kMostLanes);
  found_index_.resize((end - begin) * stride_ + kMostLanes);
  found_count_.assign(end - begin, 0);
  if (stride_ == 0 || begin == end) return;
  low_ = {kInfinity, kInfinity, kInfinity};
  high_ = -low_;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Vec3 p{search.x_[i], search.y_[i], search.z_[i]};
    low_ = lower(low_, p);
    high_ = upper(high_, p);
  }
  const Bounds box = search.levels_[0].at(begin / kBlock);
  const auto wanted = static_cast<double>(stride_);
  const double expected = kMargin * expected_reach(box.high - box.low, wanted);
  const double guess = guess_ > 0.0 ? std::min(guess_ * wanted, kTrusted * expected) : expected;
  start_ = std::min(guess, max_squared);
  collect(search, std::min(kGrowth * start_, max_squared));
  row_limit_ = -1.0;
  farthest_ = 0.0;
  for (std::uint32_t i = begin; i < end; ++i)
    if (asked.empty() || asked[i - begin] != 0) find_row(search, i, max_squared);
  guess_ = farthest_ / wanted;
}

}  // namespace orbweave
