// The surface while it grows level by level: which triangles there are, and which points still
// have room.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/fan_shape.h"
#include "engine/ball_pivoting/fan_table.h"
#include "engine/ball_pivoting/pivoting_result.h"
#include "engine/ball_pivoting/rivals.h"
#include "io/stop_token.h"

namespace orbweave {

class SurfaceState {
 public:
  SurfaceState(RivalContext context, std::span<const std::uint8_t> owned,
               const StopToken* stop = nullptr);

  /// The first level, from the fans of all points.
  void take_first_level(const FanTable& fans);
  /// A later level, from the fans of the open points.
  void take_level(const FanTable& fans);

  /// Points that a larger ball may still give triangles to: 1. Their fan is not closed, and some
  /// ball that touches them was empty.
  std::span<const std::uint8_t> unfinished() const { return unfinished_; }
  bool any_unfinished() const { return any_unfinished_; }
  /// Corners of the triangles at open points, sorted: their edges are taken.
  std::span<const VertexCorner> open_corners() const { return open_corners_; }

  /// After the last level, once: the levels become one list, and triangles that share no edge with
  /// another one go.
  void drop_isolated();

  /// After that: what is known of points that are no simple closed fan. Vertices ascending.
  void describe(std::vector<BoundaryFan>& boundary, std::vector<FanMember>& members) const;

  /// Triangles whose smallest vertex is owned, sorted.
  std::vector<Triangle> take_triangles() { return std::move(triangles_); }
  /// Number of fans at each point, at most 255.
  std::vector<std::uint8_t> take_fan_counts() { return std::move(fan_counts_); }
  std::uint64_t conflicts_lost() const { return conflicts_lost_; }
  std::uint64_t isolated_dropped() const { return isolated_dropped_; }

 private:
  bool is_owned(std::uint32_t vertex) const { return owned_.empty() || owned_[vertex] != 0; }
  bool edge_taken(std::uint32_t tail, std::uint32_t head) const;
  bool is_isolated(const Triangle& t) const;
  std::vector<VertexCorner> isolated_corners() const;
  std::vector<VertexCorner> corners_found_elsewhere(const FanTable& fans) const;
  std::vector<Triangle> first_level_losers(const FanTable& fans,
                                           std::span<const VertexCorner> elsewhere) const;
  void close_or_keep(std::span<const VertexCorner> added);
  void end_level();
  void merge_levels(std::span<const Triangle> isolated);
  void count_many_fans_anew(std::span<const VertexCorner> dropped);
  void emit_first_level(const FanTable& fans, std::span<const VertexCorner> elsewhere,
                        std::span<const Triangle> losers);

  RivalContext context_;
  std::span<const std::uint8_t> owned_;
  const StopToken* stop_;
  std::vector<std::uint8_t> open_;        // points whose fan is not closed
  std::vector<std::uint8_t> unfinished_;  // those of them that are not blocked
  std::vector<std::uint8_t> fan_counts_;
  std::vector<VertexCorner> open_corners_;          // at open points, sorted
  std::vector<std::size_t> open_begins_;            // per point: its first open corner, and the end
  std::vector<VertexCorner> pinched_corners_;       // at closed points of several fans
  std::vector<std::vector<Triangle>> first_level_;  // triangles by blocks of points, sorted
  std::vector<Triangle> later_triangles_;           // of the other levels
  std::vector<Triangle> triangles_;                 // of all levels, at last; sorted
  std::uint64_t conflicts_lost_ = 0;
  std::uint64_t isolated_dropped_ = 0;
  bool any_unfinished_ = false;
};

}  // namespace orbweave
