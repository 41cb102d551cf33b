// Which points of a cloud are measurements, and which are left out before anything is computed.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/point_cloud.h"
#include "io/points/dropped_points.h"
#include "partition/canonical_order.h"
#include "partition/point_counts.h"

namespace orbweave {

/// Coordinates beyond this have no squares of squares.
inline constexpr double kLargestCoordinate = 1e75;

/// Positions that can be computed with.
inline constexpr Box kUsableRange{{-kLargestCoordinate, -kLargestCoordinate, -kLargestCoordinate},
                                  {kLargestCoordinate, kLargestCoordinate, kLargestCoordinate}};

/// Which points of a cloud are measurements. docs/dev/raw-scans.md.
struct PointFilter {
  /// Points outside are strays.
  Box within = kUsableRange;
  /// Whether coordinates of no-data values (the largest float and its negative) are points.
  bool takes_no_data_values = true;
  /// Where points lie that were written as (0, 0, 0) in their scans. All different, ascending by x.
  std::vector<Vec3> scan_origins = {};
  /// Those of the scan origins at which points are missing returns, in the same order.
  std::vector<Vec3> missing_returns = {};
  friend bool operator==(const PointFilter&, const PointFilter&) = default;
};

/// What became of a batch's points.
struct FilteredPoints {
  DroppedPoints dropped;
  std::vector<std::uint64_t> at_scan_origins;  ///< of those kept, at each origin of the filter
};

/// Removes points with a coordinate that is not finite, where there are normals, points whose
/// normal is not finite or zero, and those that `filter` does not take; keeps the order of the
/// rest.
FilteredPoints drop_unusable(PointCloud& points, const PointFilter& filter = {});

/// What drop_unusable would leave out; removes nothing.
FilteredPoints find_unusable(const PointColumns& points, const PointFilter& filter);

/// What leaves out no-data values, and later strays and missing returns. `scan_origins`: see there.
PointFilter measurement_filter(std::vector<Vec3> scan_origins);

/// Adds counts one by one; where there are none yet, they are 0.
void add_origin_counts(std::vector<std::uint64_t>& to, std::span<const std::uint64_t> from);

/// The filter that also leaves out what the points that passed `filter` bring to light: several
/// points at the same scan origin, else strays. The same filter where there is nothing more.
/// `at_scan_origins`: points at each origin of the filter.
PointFilter narrowed(PointFilter filter, std::span<const std::uint64_t> at_scan_origins,
                     const PointCounts& counts);

}  // namespace orbweave
