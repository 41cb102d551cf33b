// Options of the algorithms from those of a job.
#pragma once

#include "engine/spacing/layer_thickness.h"
#include "io/job/job.h"

namespace orbweave {

PrepareOptions prepare_options(const CleaningChoice& choice);

}  // namespace orbweave
