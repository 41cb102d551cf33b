// What the selection of points left out of a cloud, in words.
#pragma once

#include <string>

#include "engine/pipeline/points/cloud_input.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "engine/pipeline/stage/stage_runner.h"

namespace orbweave {

/// Adds a note where points of classes that the job drops were met: how many, and the key that
/// keeps them.
void note_dropped_classes(const Job& job, CountedCloud& cloud);

/// Whether the job asks for some of the points of its scans alone, or has dropped any by class.
bool has_selected(const ResolvedJob& job, const DroppedPoints& dropped);

/// What the scans hold, for a job whose selection leaves nothing: bounds against the crop, classes
/// and their counts. Reads the scans once more, without the selection.
[[noreturn]] void refuse_empty_selection(const RunControl& control, const CountedCloud& cloud);

}  // namespace orbweave
