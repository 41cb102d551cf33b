// The first pass over scans, without what is no measurement: no-data values, missing returns that
// were written as (0, 0, 0), and strays.
#pragma once

#include <functional>

#include "engine/pipeline/points/cloud_input.h"
#include "io/job/job.h"

namespace orbweave {

/// Counts the points of `input` by `count` again and again, each time without the strays and
/// missing returns that the time before brought to light, until there are none. One call is enough
/// for a cloud without any. Notes what is left out.
CountedCloud count_without_strays(const Job& job, const CloudInput& input,
                                  const std::function<CountedCloud(const PointFilter&)>& count);

}  // namespace orbweave
