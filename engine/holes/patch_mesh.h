// A patch while it is made: triangles of a disc with their neighbours, and what may be done to
// them. The rim's edges and the loop's vertices are never touched.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/half_edges.h"
#include "engine/holes/hole.h"
#include "engine/holes/loop_triangulation.h"
#include "engine/holes/plane_triangulation.h"

namespace orbweave {

/// A triangulated disc in space, refined and relaxed.
class PatchMesh {
 public:
  /// `positions`: first the loop's corners, then interior points; `vertices`: mesh vertex of each
  /// corner; `forbidden` as in HoleProblem.
  PatchMesh(std::vector<Vec3> positions, std::span<const std::uint32_t> vertices,
            std::span<const CornerTriangle> triangles,
            std::span<const std::array<std::uint32_t, 2>> forbidden);

  const std::vector<Vec3>& positions() const { return positions_; }
  std::vector<Vec3>& positions() { return positions_; }
  std::uint32_t corners() const { return corners_; }
  std::uint32_t size() const { return static_cast<std::uint32_t>(positions_.size()); }
  std::vector<CornerTriangle> triangles() const;

  /// Splits edges inside that are longer than `longest` at their midpoints, longest first, until
  /// there is none or `max_points` new ones were made. Returns how many.
  std::uint32_t split_long_edges(double longest, std::uint32_t max_points);
  /// Joins an interior point with its neighbour over edges shorter than `shortest` where the disc
  /// stays sound.
  std::uint32_t collapse_short_edges(double shortest);
  /// Flips edges until every edge inside is locally Delaunay in space (opposite angles sum to at
  /// most pi) as far as allowed: not onto forbidden chords, existing edges or flipped-over faces.
  std::uint32_t flip_to_delaunay();
  /// Splits every chord (edge inside between two corners) that is forbidden, or joins corners of
  /// one vertex, at its midpoint. Returns how many.
  std::uint32_t split_forbidden_chords();
  /// Moves interior points to where the umbrella Laplacian of order 1 (membrane) or 2 (thin
  /// plate) vanishes; the rim stays. With order 2 `rim_ring`, one point per corner or empty, lies
  /// across the rim and makes the patch tangent to the sheet.
  void smooth(int order, std::span<const Vec3> rim_ring = {});
  /// Interior neighbours of every vertex, ascending.
  std::vector<std::vector<std::uint32_t>> neighbors() const;

 private:
  std::vector<Vec3> positions_;
  std::uint32_t corners_ = 0;
  std::vector<std::uint32_t> vertices_;
  std::vector<std::array<std::uint32_t, 2>> forbidden_;
  std::vector<CornerTriangle> triangles_;
  std::vector<std::array<std::uint32_t, 3>> across_;  ///< triangle over the edge opposite corner k
};

}  // namespace orbweave
