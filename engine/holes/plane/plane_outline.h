// A hole's rim in its plane: what lies inside, and how far from it.
#pragma once

#include <cstdint>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

/// A closed polygon (z is ignored) sorted into strips along y, so that a question looks at a few
/// edges.
class PlaneOutline {
 public:
  /// `reach`: the largest distance that will be asked for; positive.
  PlaneOutline(std::vector<Vec3> polygon, double reach);

  /// By winding number, so that an edge used in both directions is no border.
  bool contains(Vec3 x) const;
  /// The distance to the nearest edge, `reach` at most.
  double distance(Vec3 x) const;

  double reach() const { return reach_; }

  const std::vector<Vec3>& polygon() const { return polygon_; }
  Vec3 low() const { return low_; }
  Vec3 high() const { return high_; }

 private:
  std::size_t strip_of(double y) const;

  std::vector<Vec3> polygon_;
  double reach_ = 0.0;
  Vec3 low_;
  Vec3 high_;
  double strip_height_ = 1.0;
  std::vector<std::uint32_t> first_;  ///< per strip, into edges_
  std::vector<std::uint32_t> edges_;  ///< that come within reach of the strip
};

}  // namespace orbweave
