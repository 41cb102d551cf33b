// How the triangles around one vertex hang together.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/pivoting_result.h"
#include "engine/ball_pivoting/walk.h"

namespace orbweave {

/// A triangle as seen from one of its vertices.
struct VertexCorner {
  std::uint32_t vertex = 0;
  Corner corner = 0;
  friend auto operator<=>(const VertexCorner&, const VertexCorner&) = default;
};

/// Triangles around one vertex, sorted into fans.
struct FanShape {
  std::uint32_t fans = 0;
  bool closed = false;               ///< there are triangles, and every fan is a cycle
  std::vector<std::uint32_t> label;  ///< per corner: smallest first neighbour of its fan
  std::vector<BoundaryFan> open;     ///< the fans that are no cycle
};

/// Finds the shapes of many vertices one after the other; memory is taken once.
class FanFinder {
 public:
  /// `corners`: all corners at one vertex; no neighbour is first twice nor second twice. The shape
  /// is valid until the next call.
  const FanShape& shape_of(std::span<const VertexCorner> corners);

 private:
  void find_followers(std::span<const VertexCorner> corners);
  std::uint32_t label_fan(std::span<const VertexCorner> corners, std::uint32_t begin);

  FanShape shape_;
  std::vector<std::uint32_t> follower_;  // per corner: the next one of its fan; their number: none
  std::vector<std::uint8_t> is_led_to_;  // per corner: another one leads to it
  std::vector<std::uint8_t> is_seen_;
};

}  // namespace orbweave
