#include "engine/pipeline/points/trajectory_facts.h"

#include <algorithm>
#include <limits>
#include <string>

#include "engine/pipeline/points/scan_input.h"
#include "io/clouds/trajectory.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

struct Span {
  double first = std::numeric_limits<double>::infinity();
  double last = -std::numeric_limits<double>::infinity();

  std::string text() const { return format_exact(first) + " to " + format_exact(last); }
};

/// When the points of the scans were measured.
Span times_of_scans(ResolvedJob job, const StopToken& stop) {
  job.trajectory = nullptr;
  job.output.attributes = true;
  Span span;
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  const auto source = open_scans(job, stop);
  const auto time = find_time(source->schema());
  if (!time) return span;
  for (PointCloud batch; source->read(batch, kBatchPoints);)
    for (std::size_t i = 0; i < batch.size(); ++i) {
      span.first = std::min(span.first, (*time)(batch.attribute_row(i)));
      span.last = std::max(span.last, (*time)(batch.attribute_row(i)));
    }
  return span;
}

double distance(const Box& a, const Box& b) {
  Vec3 apart;
  for (int axis = 0; axis < 3; ++axis)
    apart[axis] = std::max({0.0, a.min[axis] - b.max[axis], b.min[axis] - a.max[axis]});
  return norm(apart);
}

std::string box_text(const Box& box) {
  return format_position(box.min) + " to " + format_position(box.max);
}

}  // namespace

void require_fitting_trajectory(const RunControl& control, const CountedCloud& cloud) {
  const ResolvedJob& job = control.job;
  if (!job.trajectory || !job.wants_view()) return;
  const Trajectory& path = *job.trajectory;
  constexpr std::uint64_t kFew = 100;  // one of so many
  const auto dropped = cloud.dropped.find(kOutsideTrajectory);
  const std::uint64_t outside = dropped == cloud.dropped.end() ? 0 : dropped->second;
  if (outside > cloud.points_read / kFew)
    throw_bad_input(
        "the trajectory does not cover the scans",
        {.file = job.input.trajectory,
         .found = "times from " + Span{path.first_time(), path.last_time()}.text() +
                  ", and points from " + times_of_scans(job, control.stop).text() + ", " +
                  format_count(outside) + " of " + format_count(cloud.points_read) +
                  " of them while the scanner's place is unknown",
         .expected = "the place of the scanner whenever points were measured, by the same clock",
         .advice = "Put the trajectories of all scans into one file, or leave " +
                   setting_name(job, "input.trajectory") + " out."});
  if (cloud.grid.points() == 0) return;
  // A site is no less than a hundredth of the way to an aircraft above it.
  constexpr double kFar = 200.0;
  const Box points = cloud.grid.bounds();
  const double largest =
      std::max(norm(points.max - points.min), norm(path.bounds().max - path.bounds().min));
  if (distance(points, path.bounds()) > kFar * largest)
    throw_bad_input("the trajectory lies far from the scans",
                    {.file = job.input.trajectory,
                     .found = "places from " + box_text(path.bounds()) + ", and points from " +
                              box_text(points),
                     .expected = "both in one coordinate system",
                     .advice = "Export the trajectory in the coordinates of the scans."});
}

}  // namespace orbweave
