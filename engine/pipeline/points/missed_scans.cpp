#include "engine/pipeline/points/missed_scans.h"

#include <vector>

#include "io/job/setting.h"
#include "io/system/glob.h"

namespace orbweave {

std::string objection_to_missed_scans(const ResolvedJob& job) {
  const std::vector<std::string> missed = files_in_other_case(job.input.files);
  if (missed.empty()) return {};
  const std::size_t others = missed.size() - 1;
  return missed.front() +
         (others > 0 ? " and " + std::to_string(others) + " more match" : " matches") +
         " no pattern of " + setting_name(job, "input.files") +
         " for capital and small letters alone: the mesh is made without " +
         (others > 0 ? "them" : "it");
}

}  // namespace orbweave
