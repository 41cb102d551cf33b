// The balls of the medial axis that a Power Crust is made of.
// Amenta, Choi, Kolluri, The Power Crust, 2001, section 3.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave::voronoi {

/// A ball of the medial axis.
struct MedialBall {
  Vec3 center;
  double radius = 0.0;
};

/// Balls of the poles, each place once, in the order of the first points whose poles they are.
struct PolarBalls {
  std::vector<MedialBall> balls;
  std::vector<std::uint8_t> outer;  ///< known to be outside: the cell has a bounding point
  /// Points that each ball touches, ascending: those of ball b are `touched[touched_begin[b]]` to
  /// `touched[touched_begin[b + 1]]` (exclusive).
  std::vector<std::uint32_t> touched, touched_begin = {0};
  /// Balls of the two poles of each point; kNone: none.
  std::vector<std::uint32_t> first, second;
  /// Per point: minus the cosine of the angle between the directions to its two poles, at least 0.
  std::vector<double> opposite_weight;

  std::span<const std::uint32_t> touched_by(std::uint32_t ball) const {
    return std::span(touched).subspan(touched_begin[ball],
                                      touched_begin[ball + 1] - touched_begin[ball]);
  }
  std::vector<Vec3> centers() const;
  std::vector<double> weights() const;  ///< squared radii
};

}  // namespace orbweave::voronoi
