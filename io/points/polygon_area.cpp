#include "io/points/polygon_area.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace orbweave {
namespace {

/// Where a point lies to a ring.
enum class Side { kOutside, kOn, kInside };

/// A sum of doubles without common bits, the smallest first, as far as it has got.
/// Shewchuk: Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates,
/// 1997, sections 2.3 to 2.5.
class ExactSum {
 public:
  void add(double value) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < size_; ++i) {
      const double sum = value + parts_[i];
      const double rest = sum - value;
      const double error = (value - (sum - rest)) + (parts_[i] - rest);
      if (error != 0.0) parts_[kept++] = error;
      value = sum;
    }
    if (value != 0.0) parts_[kept++] = value;
    size_ = kept;
  }
  /// Adds a * b.
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }
  /// The largest part decides.
  double sign() const { return size_ == 0 ? 0.0 : parts_[size_ - 1]; }

 private:
  std::array<double, 16> parts_{};
  std::size_t size_ = 0;
};

/// (a - p) x (b - p) = a x b - a x p - p x b, without rounding.
double exact_turn(AreaPoint a, AreaPoint b, AreaPoint p) {
  ExactSum sum;
  sum.add_product(a[0], b[1]);
  sum.add_product(-a[1], b[0]);
  sum.add_product(-a[0], p[1]);
  sum.add_product(a[1], p[0]);
  sum.add_product(-p[0], b[1]);
  sum.add_product(p[1], b[0]);
  return sum.sign();
}

/// Positive where p lies to the left of the way from a to b, 0 where it lies on the line.
double turn(AreaPoint a, AreaPoint b, AreaPoint p) {
  // Shewchuk, section 4.2: the bound for the first approximation.
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon() / 2.0;
  constexpr double kBound = (3.0 + 16.0 * kEpsilon) * kEpsilon;
  const double left = (a[0] - p[0]) * (b[1] - p[1]);
  const double right = (a[1] - p[1]) * (b[0] - p[0]);
  const double difference = left - right;
  if (std::abs(difference) > kBound * (std::abs(left) + std::abs(right))) return difference;
  return exact_turn(a, b, p);
}

bool is_between(double value, double a, double b) {
  return value >= std::min(a, b) && value <= std::max(a, b);
}

/// What one edge does to the even-odd rule of a ring. An edge owns its lower end and not its upper
/// one, so that a corner counts once.
void cross(AreaPoint from, AreaPoint to, AreaPoint p, Side& side) {
  if (side == Side::kOn || !is_between(p[1], from[1], to[1])) return;
  const double at = turn(from, to, p);
  if (at == 0.0 && is_between(p[0], from[0], to[0])) {
    side = Side::kOn;
    return;
  }
  if ((from[1] <= p[1]) == (to[1] <= p[1])) return;
  const bool lies_left = to[1] > from[1] ? at > 0.0 : at < 0.0;
  if (lies_left) side = side == Side::kInside ? Side::kOutside : Side::kInside;
}

}  // namespace

PolygonArea::PolygonArea(const std::vector<AreaPolygon>& polygons) {
  for (std::uint32_t i = 0; i < polygons.size(); ++i) {
    add_ring(polygons[i].outer, i, false);
    for (const auto& hole : polygons[i].holes) add_ring(hole, i, true);
  }
  constexpr double kFar = std::numeric_limits<double>::infinity();
  bounds_.min.z = -kFar;
  bounds_.max.z = kFar;
  index_edges();
}

void PolygonArea::add_ring(const std::vector<AreaPoint>& ring, std::uint32_t polygon,
                           bool is_hole) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const AreaPoint& to = ring[(i + 1) % ring.size()];
    edges_.push_back({ring[i], to, polygon, rings_, is_hole});
    bounds_.extend(Vec3{to[0], to[1], 0.0});
  }
  ++rings_;
}

std::size_t PolygonArea::strip_of(double y) const {
  const double height = bounds_.max.y - bounds_.min.y;
  if (!(height > 0.0)) return 0;
  const double place = (y - bounds_.min.y) / height * static_cast<double>(strips_);
  return std::min(static_cast<std::size_t>(std::max(place, 0.0)), strips_ - 1);
}

std::uint64_t PolygonArea::entries_with(std::size_t strips) const {
  const double height = bounds_.max.y - bounds_.min.y;
  double entries = 0.0;
  for (const Edge& edge : edges_)
    entries += 2.0 + std::abs(edge.to[1] - edge.from[1]) / height * static_cast<double>(strips);
  return static_cast<std::uint64_t>(std::min(entries, 1e18));
}

/// As many strips as edges, fewer where edges are so long that each would be in many.
void PolygonArea::index_edges() {
  constexpr std::uint64_t kMostPerEdge = 8;
  strips_ = bounds_.max.y > bounds_.min.y ? edges_.size() : 1;
  while (strips_ > 1 && entries_with(strips_) > kMostPerEdge * edges_.size()) strips_ /= 2;
  strip_begin_.assign(strips_ + 1, 0);
  const auto for_each_strip = [&](const Edge& edge, const auto& visit) {
    const std::size_t last = strip_of(std::max(edge.from[1], edge.to[1]));
    for (std::size_t s = strip_of(std::min(edge.from[1], edge.to[1])); s <= last; ++s) visit(s);
  };
  for (const Edge& edge : edges_)
    for_each_strip(edge, [&](std::size_t strip) { ++strip_begin_[strip + 1]; });
  for (std::size_t s = 0; s < strips_; ++s) strip_begin_[s + 1] += strip_begin_[s];
  strip_edges_.resize(strip_begin_.back());
  std::vector<std::uint64_t> next(strip_begin_.begin(), strip_begin_.end() - 1);
  for (std::uint32_t i = 0; i < edges_.size(); ++i)
    for_each_strip(edges_[i], [&](std::size_t strip) { strip_edges_[next[strip]++] = i; });
}

bool PolygonArea::contains(double x, double y) const {
  if (!bounds_.contains({x, y, 0.0})) return false;
  const std::size_t strip = strip_of(y);
  std::uint64_t at = strip_begin_[strip];
  const std::uint64_t end = strip_begin_[strip + 1];
  bool is_in_polygon = false;
  while (at != end) {
    const Edge& first = edges_[strip_edges_[at]];
    Side side = Side::kOutside;
    for (; at != end && edges_[strip_edges_[at]].ring == first.ring; ++at)
      cross(edges_[strip_edges_[at]].from, edges_[strip_edges_[at]].to, {x, y}, side);
    if (first.is_hole)
      is_in_polygon = is_in_polygon && side != Side::kInside;
    else
      is_in_polygon = side != Side::kOutside;
    const bool ends = at == end || edges_[strip_edges_[at]].polygon != first.polygon;
    if (ends && is_in_polygon) return true;
    if (ends) is_in_polygon = false;
  }
  return false;
}

}  // namespace orbweave
