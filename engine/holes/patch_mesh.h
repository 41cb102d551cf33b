// A patch while it is made: triangles of a disc with their neighbours, and what may be done to
// them. The rim's edges and the loop's vertices are never touched.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/hole.h"

namespace orbweave {

/// A point of the hole's plane on an integer grid of at most kPlaneExtent either way, so that
/// orientation and in-circle tests are exact.
struct PlanePoint {
  std::int64_t x = 0;
  std::int64_t y = 0;
  friend bool operator==(const PlanePoint&, const PlanePoint&) = default;
};
inline constexpr std::int64_t kPlaneExtent = std::int64_t{1} << 26;

/// Twice the signed area; exact.
std::int64_t orientation(PlanePoint a, PlanePoint b, PlanePoint c);
/// Positive when d is inside the circle of the counter-clockwise a, b, c; exact.
int side_of_circle(PlanePoint a, PlanePoint b, PlanePoint c, PlanePoint d);

/// Corners of a loop, 0 to n - 1 in its order, then interior points. Corners that are the same
/// vertex of the mesh are different corners here: patches are discs of corners.
using CornerTriangle = std::array<std::uint32_t, 3>;

/// True when no two edges of the closed polygon cross or overlap and its area is positive;
/// corners may coincide (a loop that touches itself). O(n^2) at most, by a grid much less.
bool is_weakly_simple(std::span<const PlanePoint> polygon);

/// Constrained Delaunay triangulation of the polygon with interior points, all counter-clockwise.
/// `points`: first the polygon's `corners` corners, then the interior points; those outside the
/// polygon, on its edges or equal to another are left out (nothing refers to them). Empty where
/// the polygon is not weakly simple. Chords that `is_forbidden(corner, corner)` are avoided where
/// flips can.
std::vector<CornerTriangle> triangulate_polygon(std::span<const PlanePoint> points,
                                                std::uint32_t corners);

/// Triangulation of a loop in space without new points, of the least largest dihedral angle
/// (rim included where `rim_normals`, one per edge, is not empty), then of the least area; O(n^3)
/// up to `exact_corners` corners, larger loops are closed by cutting ears of the least angle.
/// Chords in `forbidden` (pairs of corners as vertices) are not used. Empty where that is
/// impossible.
/// Barequet, Sharir: Filling Gaps in the Boundary of a Polyhedron, CAGD 1995; Liepa: Filling Holes
/// in Meshes, SGP 2003.
struct LoopInSpace {
  std::span<const Vec3> corners;            ///< positions along the loop
  std::span<const std::uint32_t> vertices;  ///< which mesh vertex each corner is
  std::span<const Vec3> rim_normals;        ///< of the face behind edge (i, i + 1); or empty
  std::span<const std::array<std::uint32_t, 2>> forbidden;  ///< mesh vertices, sorted
};
std::vector<CornerTriangle> triangulate_loop(const LoopInSpace& loop,
                                             std::uint32_t exact_corners = 160);

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
