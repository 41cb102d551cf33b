// Strays: small groups of points so far away from all others that they are no part of what was
// scanned. Root cube, radii and order are chosen without them: one stray would take the resolution
// of all other points.
#pragma once

#include <optional>

#include "io/box.h"
#include "partition/point_counts.h"

namespace orbweave {

/// Points of a group that is farther from the body than kStrayExtents extents of the body are
/// strays. (A little less than the hundred that is promised, as cells are no points.)
inline constexpr double kStrayExtents = 64.0;

/// A box that holds all points but strays, and no stray; empty where there are none. The body
/// begins with the box that is left when, along each axis, the hundredth of the points that come
/// first and that come last are put aside (of few points up to three, fewer than a quarter). It
/// grows outwards, the same in all directions, as long as no gap of kStrayExtents extents of what
/// lies within is met. What does not hold half of the points is no body: then there are no strays.
/// Larger groups hence are never strays. Where the grid knows cells and no points, only that is a
/// stray which is one wherever in the cells the points lie: what is near the body in cells as wide
/// as a far stray makes them is seen once that stray is gone, in a grid of its own. Depends on the
/// points alone. O(cells log cells) where there may be strays, O(cells) otherwise.
std::optional<Box> box_without_strays(const PointCounts& grid);

}  // namespace orbweave
