// Ears of a loop in space, by their angles.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <queue>
#include <utility>

#include "engine/holes/triangulation/loop_chords.h"

namespace orbweave {
namespace {

/// Twice the area vector of the loop.
Vec3 area_vector(std::span<const Vec3> corners) {
  Vec3 sum;
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    sum = sum + cross(corners[i] - corners[0], corners[i + 1] - corners[0]);
  }
  return sum;
}

/// Corners along the axis of their largest extent.
class CornerLine {
 public:
  explicit CornerLine(std::span<const Vec3> corners) : order_(corners.size()) {
    double widest = -1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto [low, high] = std::minmax_element(
          corners.begin(), corners.end(), [&](Vec3 a, Vec3 b) { return a[axis] < b[axis]; });
      const double extent = (*high)[axis] - (*low)[axis];
      if (extent > widest) axis_ = axis;
      widest = std::max(widest, extent);
    }
    std::iota(order_.begin(), order_.end(), 0U);
    std::stable_sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return corners[a][axis_] < corners[b][axis_];
    });
    for (const std::uint32_t corner : order_) along_.push_back(corners[corner][axis_]);
  }

  /// Corners that can lie between a, b and c.
  std::span<const std::uint32_t> near(Vec3 a, Vec3 b, Vec3 c) const {
    const auto low = std::min({a[axis_], b[axis_], c[axis_]});
    const auto high = std::max({a[axis_], b[axis_], c[axis_]});
    const auto first = std::lower_bound(along_.begin(), along_.end(), low) - along_.begin();
    const auto last = std::upper_bound(along_.begin(), along_.end(), high) - along_.begin();
    return std::span(order_).subspan(first, last - first);
  }

 private:
  int axis_ = 0;
  std::vector<std::uint32_t> order_;
  std::vector<double> along_;
};

double angle_between(Vec3 a, Vec3 b) { return std::atan2(norm(cross(a, b)), dot(a, b)); }

/// True when p lies over or under the triangle, no further away than half its longest edge.
bool is_over(Vec3 p, Vec3 a, Vec3 b, Vec3 c, Vec3 normal) {
  const double longest = std::max({squared_norm(b - a), squared_norm(c - b), squared_norm(a - c)});
  const double height = dot(p - a, normal);
  return 4.0 * height * height < longest && dot(cross(b - a, p - a), normal) > 0.0 &&
         dot(cross(c - b, p - b), normal) > 0.0 && dot(cross(a - c, p - c), normal) > 0.0;
}

class EarQueue {
 public:
  EarQueue(const LoopInSpace& loop, const LoopChords& chords)
      : loop_(loop), chords_(chords), line_(loop.corners), count_(loop.corners.size()) {
    const auto n = static_cast<std::uint32_t>(count_);
    behind_.assign(n, normalized(area_vector(loop.corners)));
    if (!loop.rim_normals.empty()) behind_.assign(loop.rim_normals.begin(), loop.rim_normals.end());
    stamp_.assign(n, 0);
    for (std::uint32_t i = 0; i < n; ++i) {
      before_.push_back(i == 0 ? n - 1 : i - 1);
      after_.push_back(i + 1 == n ? 0 : i + 1);
    }
    for (std::uint32_t i = 0; i < n; ++i) push(i);
  }

  void cut(std::size_t keep, std::vector<CornerTriangle>& out) {
    while (count_ > keep && !queue_.empty()) {
      const Ear ear = queue_.top();
      queue_.pop();
      if (ear.stamp == stamp_[ear.corner]) cut_one(ear.corner, out);
    }
  }

  LoopRest rest() const {
    LoopRest rest;
    std::uint32_t corner = 0;
    while (stamp_[corner] == kGone) ++corner;
    for (std::size_t i = 0; i < count_; ++i, corner = after_[corner]) {
      rest.ring.push_back(corner);
      rest.behind.push_back(behind_[corner]);
    }
    return rest;
  }

 private:
  static constexpr std::uint32_t kGone = std::numeric_limits<std::uint32_t>::max();
  struct Ear {
    double key;
    std::uint32_t corner, stamp;
    bool operator<(const Ear& other) const {  // the top of the queue is its largest
      return std::pair(key, corner) > std::pair(other.key, other.corner);
    }
  };
  Vec3 at(std::uint32_t corner) const { return loop_.corners[corner]; }

  void push(std::uint32_t corner) {
    const std::uint32_t stamp = ++stamp_[corner];
    if (!chords_.allows(before_[corner], after_[corner])) return;
    queue_.push({key(corner), corner, stamp});
  }

  double key(std::uint32_t corner) const {
    const std::uint32_t a = before_[corner];
    const std::uint32_t c = after_[corner];
    const Vec3 normal = facet(at(a), at(corner), at(c)).normal;
    constexpr double kLast = 4.0 * std::numbers::pi;
    if (normal == Vec3{}) return 2.0 * kLast;
    double bend = 0.0;
    for (const Vec3 other : {behind_[a], behind_[corner]}) {
      if (other != Vec3{}) bend = std::max(bend, angle_between(normal, other));
    }
    const double opening = angle_between(at(a) - at(corner), at(c) - at(corner));
    return bend + opening + (covers_another(a, corner, c, normal) ? kLast : 0.0);
  }

  bool covers_another(std::uint32_t a, std::uint32_t b, std::uint32_t c, Vec3 normal) const {
    const auto near = line_.near(at(a), at(b), at(c));
    return std::any_of(near.begin(), near.end(), [&](std::uint32_t i) {
      return stamp_[i] != kGone && i != a && i != b && i != c &&
             is_over(at(i), at(a), at(b), at(c), normal);
    });
  }

  void cut_one(std::uint32_t corner, std::vector<CornerTriangle>& out) {
    const std::uint32_t a = before_[corner];
    const std::uint32_t c = after_[corner];
    out.push_back({a, corner, c});
    behind_[a] = facet(at(a), at(corner), at(c)).normal;
    after_[a] = c;
    before_[c] = a;
    stamp_[corner] = kGone;
    --count_;
    push(a);
    push(c);
  }

  const LoopInSpace& loop_;
  const LoopChords& chords_;
  CornerLine line_;
  std::size_t count_;
  std::vector<std::uint32_t> before_, after_;
  std::vector<Vec3> behind_;          ///< normal behind the edge from a corner to the one after it
  std::vector<std::uint32_t> stamp_;  ///< of the corner's valid entry in the queue
  std::priority_queue<Ear> queue_;
};

LoopRest whole(const LoopInSpace& loop) {
  LoopRest rest;
  rest.ring.resize(loop.corners.size());
  std::iota(rest.ring.begin(), rest.ring.end(), 0U);
  rest.behind.assign(loop.rim_normals.begin(), loop.rim_normals.end());
  rest.behind.resize(rest.ring.size());
  return rest;
}

}  // namespace

LoopRest cut_ears(const LoopInSpace& loop, const LoopChords& chords, std::uint32_t keep,
                  std::vector<CornerTriangle>& out) {
  if (loop.corners.size() <= keep) return whole(loop);
  EarQueue queue(loop, chords);
  queue.cut(keep, out);
  return queue.rest();
}

}  // namespace orbweave
