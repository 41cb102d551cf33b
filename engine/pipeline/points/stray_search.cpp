#include "engine/pipeline/points/stray_search.h"

#include <string>
#include <vector>

#include "engine/pipeline/points/selection_facts.h"
#include "io/job/setting.h"
#include "io/report/reasons.h"
#include "io/text/quantity.h"
#include "partition/point_filter.h"

namespace orbweave {
namespace {

void note_beyond_range(CountedCloud& cloud) {
  const char* const reason = text_of(DropReason::kBeyondRange);
  const auto found = cloud.dropped.find(reason);
  if (found == cloud.dropped.end()) return;
  cloud.notes.push_back("points that cannot be computed with are left out (" +
                        format_count(found->second) + " dropped: " + reason +
                        "); no key keeps them: a scan in other units may be closer to zero");
}

void note_left_out(const Job& job, CountedCloud& cloud) {
  std::string text;
  for (const DropReason dropped :
       {DropReason::kNoDataValue, DropReason::kMissingReturn, DropReason::kStray}) {
    const char* reason = text_of(dropped);
    const auto found = cloud.dropped.find(reason);
    if (found == cloud.dropped.end()) continue;
    text += (text.empty() ? "" : "; ") + format_count(found->second) + " dropped: " + reason;
  }
  if (text.empty()) return;
  cloud.notes.push_back("points that are no measurements are left out (" + text + "); " +
                        setting(job, "input.keep_strays", "true") + " keeps them");
}

}  // namespace

CountedCloud count_without_strays(const Job& job, const CloudInput& input,
                                  const std::function<CountedCloud(const PointFilter&)>& count) {
  PointFilter filter;
  if (input.leaves_out_strays) filter = measurement_filter(input.scan_origins);
  for (;;) {
    CountedCloud cloud = count(filter);
    filter = input.leaves_out_strays ? narrowed(cloud.filter, cloud.at_scan_origins, cloud.grid)
                                     : cloud.filter;
    if (filter != cloud.filter) continue;
    if (input.are_scans) note_dropped_classes(job, cloud);
    note_left_out(job, cloud);
    note_beyond_range(cloud);
    return cloud;
  }
}

}  // namespace orbweave
