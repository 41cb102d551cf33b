#include "engine/pipeline/budget/time_forecast.h"

#include <algorithm>
#include <array>

#include "io/report/reasons.h"

namespace orbweave {
namespace {

/// Points per second and core of the whole pipeline, from file to file, on a clean surface with
/// normals and one radius: 10 million points in 8.4 s and 100 million in 91 s on two cores.
constexpr double kPointsPerSecond = 600'000.0;
/// What every further radius costs, of the first one's time.
constexpr double kFurtherRadius = 1.0;
/// Likewise of the passes over raw points (docs/cleaning.md), and of the open points and holes that
/// real scans have.
constexpr double kNormalsPerSecond = 900'000.0;
constexpr double kPropagatedPerSecond = 1'300'000.0;
constexpr double kSmoothedPerSecond = 1'000'000.0;
constexpr double kOpenPerSecond = 150'000.0;
/// What compressing the work directory adds (docs/disk.md).
constexpr double kCompressedPerSecond = 750'000.0;

/// Core seconds per point of the passes over raw points.
double raw_passes_per_point(const NormalFacts& normals, const CleaningOptions& cleaning) {
  double seconds = 0.0;
  if (normals.source == NormalSource::kEstimate)
    seconds += 1.0 / kNormalsPerSecond + 1.0 / kOpenPerSecond;
  if (normals.orientation == Orientation::kPropagate) seconds += 1.0 / kPropagatedPerSecond;
  if (cleaning.outlier_sigma > 0.0) seconds += 1.0 / kNormalsPerSecond;
  if (cleaning.smooth_radius > 0.0) seconds += cleaning.smooth_passes / kSmoothedPerSecond;
  return seconds;
}

/// With those that the stages of the job dropped.
std::uint64_t usable_points(const Partition& partition) {
  constexpr std::array kDroppedByStages = {DropReason::kDuplicate, DropReason::kOutlier,
                                           DropReason::kMerged, DropReason::kThinned,
                                           DropReason::kTooFewNeighbors};
  std::uint64_t points = partition.points();
  for (const DropReason reason : kDroppedByStages) {
    const auto dropped = partition.dropped.find(text_of(reason));
    if (dropped != partition.dropped.end()) points += dropped->second;
  }
  return points;
}

}  // namespace

double predicted_seconds(const ResolvedJob& job, const Partition& partition,
                         std::span<const double> radii, int processes) {
  const double further = static_cast<double>(std::max<std::size_t>(radii.size(), 1) - 1);
  double per_point = (1.0 + kFurtherRadius * further) / kPointsPerSecond;
  per_point += raw_passes_per_point(partition.normals, partition.cleaning.options);
  if (job.run.compress) per_point += 1.0 / kCompressedPerSecond;
  return static_cast<double>(usable_points(partition)) * per_point / (job.threads() * processes);
}

}  // namespace orbweave
