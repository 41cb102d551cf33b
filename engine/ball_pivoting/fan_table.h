// The fans of all points: what the walks found, before rivals are weighed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/cell_grid.h"
#include "engine/ball_pivoting/fan_shape.h"
#include "engine/ball_pivoting/walk.h"
#include "io/stop_token.h"

namespace orbweave {

/// Corners per point, in terms of input indices.
class FanTable {
 public:
  explicit FanTable(std::size_t points) : begin_(points, nullptr), count_(points, 0) {}

  std::span<const Corner> at(std::uint32_t point) const { return {begin_[point], count_[point]}; }
  /// The walk closed: one cycle of accepted triangles, no neighbour twice.
  bool closed(std::uint32_t point) const { return closed_[point] != 0; }
  /// No ball at the point is empty, and no larger one would be (Fan::blocked).
  bool blocked(std::uint32_t point) const { return blocked_[point] != 0; }
  bool contains(std::uint32_t point, Corner corner) const {
    for (const Corner c : at(point)) {
      if (c == corner) return true;
    }
    return false;
  }
  std::size_t points() const { return begin_.size(); }

 private:
  friend FanTable walk_all(const CellGrid&, double, std::span<const std::uint8_t>, VectorWidth,
                           const StopToken*, std::span<const VertexCorner>);
  void walk_everywhere(const CellGrid& grid, double ball_radius, WalkKernel kernel,
                       const StopToken* stop);
  void walk_at_active(const CellGrid& grid, double ball_radius,
                      std::span<const std::uint8_t> active, std::span<const VertexCorner> taken,
                      WalkKernel kernel, const StopToken* stop);
  std::vector<const Corner*> begin_;
  std::vector<std::uint32_t> count_;
  std::vector<std::uint8_t> closed_, blocked_;
  std::vector<std::vector<Corner>> blocks_;  // what begin_ points into
};

/// Walks at every point of the grid; with `active` (by input index) given, only at active ones,
/// and triangles of active points are found once, at the first of their vertices in the grid's
/// order, which is fixed in space. Parallel on the calling arena; the result does
/// not depend on the number of threads nor on the vector width. `taken`, sorted, by input index:
/// the corners of triangles that there are; a triangle with one of their directed edges may be left
/// out.
FanTable walk_all(const CellGrid& grid, double ball_radius, std::span<const std::uint8_t> active,
                  VectorWidth width, const StopToken* stop = nullptr,
                  std::span<const VertexCorner> taken = {});

}  // namespace orbweave
