// Constrained Delaunay triangulation of a hole's rim in its plane, with interior points.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/triangulation/corner_triangle.h"
#include "engine/holes/triangulation/plane_point.h"

namespace orbweave {

/// True when the closed polygon runs counter-clockwise around one disc: no two edges cross or
/// overlap, no corner lies on another edge, and successive corners differ. Corners may coincide (a
/// loop that touches itself) as long as the inside is not pinched to nothing there; an edge may be
/// used in both directions where the inside lies on both sides (a bridge to an island, or a slit).
/// O(n log n) in practice.
bool is_weakly_simple(std::span<const PlanePoint> polygon);

/// Constrained Delaunay triangulation of the polygon with interior points, all counter-clockwise
/// and of positive area: with k points taken, corners - 2 + 2 k triangles, each edge of the
/// polygon in one of them.
/// `points`: first the polygon's `corners` corners, then the interior points; those outside the
/// polygon, on its edges or equal to another are left out (nothing refers to them). Empty where
/// the polygon is not weakly simple or a point is out of kPlaneExtent. Chords that
/// `is_forbidden(corner, corner)` are flipped away where the four points around allow it; they are
/// then not Delaunay.
/// O(n log n) in practice: a point is found by walking from the one before it along a Hilbert
/// curve, in rounds of doubling size.
/// Amenta, Choi, Rote: Incremental Constructions con BRIO, 2003; Anglada: An Improved Incremental
/// Algorithm for Constructing Restricted Delaunay Triangulations, 1997 (edges of the polygon).
std::vector<CornerTriangle> triangulate_polygon(std::span<const PlanePoint> points,
                                                std::uint32_t corners,
                                                const ForbiddenChord& is_forbidden = {});

}  // namespace orbweave
