// Delaunay and regular triangulations of points in space.
#pragma once

#include <cstdint>
#include <span>

#include "engine/voronoi/share_done.h"
#include "engine/voronoi/tetrahedra.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// The Delaunay triangulation. Depends on the points alone: cospherical points are told apart by
/// their coordinates, and centres are computed from the vertices in ascending order, exactly where
/// rounding would show. A point that lies exactly on one before it is a vertex of nothing. Throws
/// Error (bad input) where all points lie in one plane. O(n log n) for points on a surface; some
/// 650 bytes per point. `stop` is looked at every thousand points, when `done` hears of the share
/// that is inserted.
Tetrahedra delaunay(std::span<const Vec3> points, const StopToken* stop = nullptr,
                    const ShareDone& done = {});

/// The same without centres and radii.
Tetrahedra delaunay_without_centers(std::span<const Vec3> points, const StopToken* stop = nullptr,
                                    const ShareDone& done = {});

/// Throws as delaunay() where all points lie in one plane. O(n), exact.
void require_volume(std::span<const Vec3> points);

/// Whether all points lie in one plane, and not on one line. O(n), exact.
bool lie_in_one_plane(std::span<const Vec3> points);

/// The regular triangulation of weighted points, the dual of their power diagram: `weights` are the
/// squared radii of the balls. Balls without a cell of their own are vertices of nothing. Otherwise
/// as delaunay().
Tetrahedra regular_triangulation(std::span<const Vec3> points, std::span<const double> weights,
                                 const StopToken* stop = nullptr, const ShareDone& done = {});

/// The triangulations alone as users of CGAL make them, from a range of points and with no more
/// than the predicates of its kernel: the number of their tetrahedra. For the benchmark, which
/// measures the methods in multiples of these.
std::uint64_t count_delaunay(std::span<const Vec3> points);
std::uint64_t count_regular(std::span<const Vec3> points, std::span<const double> weights);

}  // namespace orbweave::voronoi
