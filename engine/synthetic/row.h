// A row of points on a surface, and rows that share a number of points.
#pragma once

#include <cstdint>
#include <vector>

namespace orbweave::synthetic {

inline constexpr double kRowDistance = 0.86602540378443864676;    ///< sqrt(3)/2, in spacings
inline constexpr double kPointDistance = 1.15470053837925152902;  ///< 2/sqrt(3), in spacings

/// One row of a sheet at constant v; u runs along it.
struct Row {
  std::uint64_t first = 0;  ///< index of its first point in the cloud
  std::uint64_t count = 0;
  double v = 0.0;
  double begin = 0.0;  ///< u of the first point (closed rows: the phase, in steps)
  double end = 1.0;    ///< u of the last point (open rows)
  /// Open rows: the points inside are moved by this part of a step, so that neighbouring rows
  /// are staggered while their ends stay on the border.
  double stagger = 0.0;
  int sheet = 0;
  bool closed = false;
};

/// u of point k of a row.
double along(const Row& row, std::uint64_t k);

/// Gives rows their counts, in proportion to `weights`, so that exactly `points` are spent:
/// every partial sum is rounded. Appends the rows that got any.
void append_counted(std::vector<Row>& rows, std::vector<Row> sheet,
                    const std::vector<double>& weights, std::uint64_t points);

}  // namespace orbweave::synthetic
