#include "engine/voronoi/certified_cells.h"

#include <algorithm>
#include <cmath>

namespace orbweave::voronoi {
namespace {

/// Radii and places are taken for wrong by that share of the distances: more than they are.
constexpr double kSlack = 1e-6;

class Certificate {
 public:
  Certificate(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const KnownPart& part)
      : points_(points), tetrahedra_(tetrahedra), part_(part) {
    for (int axis = 0; axis < 3; ++axis) {
      add_unknown(axis, part.cloud.min[axis], part.box.min[axis]);
      add_unknown(axis, part.box.max[axis], part.cloud.max[axis]);
    }
  }

  bool holds(std::uint32_t cell) const {
    if (unknown_.empty()) return true;
    return tetrahedra_.is_finite(cell) ? holds_ball(cell) : holds_beyond_hull(cell);
  }

 private:
  /// The part of the cloud's box between two planes, where there is one.
  void add_unknown(int axis, double from, double to) {
    if (!(from < to)) return;
    Box slab = part_.cloud;
    slab.min[axis] = from;
    slab.max[axis] = std::min(to, slab.max[axis]);
    unknown_.push_back(slab);
  }

  bool holds_ball(std::uint32_t cell) const {
    const Vec3 center = tetrahedra_.centers[cell];
    const double reach = tetrahedra_.radii[cell] * (1.0 + kSlack);
    bool is_known = true;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = std::max(center[axis] - reach, part_.cloud.min[axis]);
      const double high = std::min(center[axis] + reach, part_.cloud.max[axis]);
      if (low > high) return true;  // beside the cloud
      is_known = is_known && low >= part_.box.min[axis] && high <= part_.box.max[axis];
    }
    return is_known;
  }

  /// Whether no place that is not known lies beyond the hull's facet.
  bool holds_beyond_hull(std::uint32_t cell) const {
    const Vec3 normal = tetrahedra_.centers[cell];
    const auto& vertices = tetrahedra_.vertices[cell];
    const std::uint32_t p = vertices[0] == kInfinite ? vertices[1] : vertices[0];
    return std::none_of(unknown_.begin(), unknown_.end(), [&](const Box& slab) {
      double farthest = 0.0, terms = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double end = normal[axis] > 0.0 ? slab.max[axis] : slab.min[axis];
        const double along = normal[axis] * (end - points_[p][axis]);
        farthest += along;
        terms += std::abs(along);
      }
      return farthest > -kSlack * terms;
    });
  }

  std::span<const Vec3> points_;
  const Tetrahedra& tetrahedra_;
  KnownPart part_;
  std::vector<Box> unknown_;
};

}  // namespace

std::vector<std::uint8_t> certified_cells(std::span<const Vec3> points,
                                          const Tetrahedra& tetrahedra, const KnownPart& part,
                                          const StopToken* stop) {
  const Certificate certificate(points, tetrahedra, part);
  std::vector<std::uint8_t> certified(points.size(), 1);
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    if (certificate.holds(c)) continue;
    for (const std::uint32_t p : tetrahedra.vertices[c])
      if (p != kInfinite) certified[p] = 0;
  }
  return certified;
}

}  // namespace orbweave::voronoi
