#include "engine/geometry/point_tree.h"

#include <algorithm>
#include <limits>

#include <nanoflann.hpp>

namespace orbweave {
namespace {

struct Positions {
  std::span<const Vec3> points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points[i][static_cast<int>(axis)];
  }
  template <class Bounds>
  bool kdtree_get_bbox(Bounds&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Positions>,
                                                 Positions, 3, std::uint32_t>;

/// Keeps the best `count` by (distance, index), in order.
class Best {
 public:
  using DistanceType = double;
  Best(std::size_t count, std::vector<Neighbor>& found) : count_(count), found_(found) {
    found_.clear();
  }
  bool full() const { return found_.size() >= count_; }
  std::size_t size() const { return found_.size(); }
  /// A little more than the worst kept: the tree drops candidates at or beyond this, and among
  /// equally far ones the index decides.
  double worstDist() const { return worst_; }
  bool addPoint(double squared_distance, std::uint32_t index) {
    const Neighbor candidate{squared_distance, index};
    if (full()) {
      if (!kNearerFirst(candidate, found_.back())) return true;
      found_.pop_back();
    }
    found_.insert(std::upper_bound(found_.begin(), found_.end(), candidate, kNearerFirst),
                  candidate);
    if (full())
      worst_ = found_.back().squared_distance * (1.0 + 1e-14) + std::numeric_limits<double>::min();
    return true;
  }

 private:
  std::size_t count_;
  std::vector<Neighbor>& found_;
  double worst_ = std::numeric_limits<double>::infinity();
};

}  // namespace

struct PointTree::State {
  Positions positions;
  Tree tree;
  explicit State(std::span<const Vec3> points)
      : positions{points}, tree(3, positions, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}
};

PointTree::PointTree(std::span<const Vec3> positions)
    : state_(std::make_unique<State>(positions)) {}
PointTree::~PointTree() = default;
PointTree::PointTree(PointTree&&) noexcept = default;
PointTree& PointTree::operator=(PointTree&&) noexcept = default;

void PointTree::nearest(Vec3 query, std::size_t count, std::vector<Neighbor>& found) const {
  const double coordinates[3] = {query.x, query.y, query.z};
  Best best(count, found);
  if (count == 0 || state_->positions.points.empty()) return;
  state_->tree.findNeighbors(best, coordinates, nanoflann::SearchParams());
}

Neighbor PointTree::nearest(Vec3 query) const {
  std::vector<Neighbor> found;
  nearest(query, 1, found);
  return found.front();
}

}  // namespace orbweave
