#include "engine/pipeline/points/missing_poses.h"

#include <optional>

#include "io/job/setting.h"
#include "io/points/poses_beside.h"

namespace orbweave {

std::string objection_to_missing_poses(const ResolvedJob& job) {
  if (job.files.size() < 2 || !job.poses.empty()) return {};
  const std::optional<PosesBeside> beside = poses_beside(job.files);
  if (!beside) return {};
  const bool can_be_read = beside->file.extension() == ".conf";
  return "the scans are taken to fit as they are, but " + beside->file.string() + " names " +
         beside->scan + ": if the file holds their poses, give them by " +
         setting_name(job, can_be_read ? "input.poses" : "input.pose");
}

}  // namespace orbweave
