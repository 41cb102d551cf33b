// The texts of what a run decided: one place for the report, messages and stored documents.
#pragma once

#include <cstdint>
#include <string_view>

#include "io/job/job.h"
#include "io/open_reason.h"
#include "io/points/dropped_points.h"

namespace orbweave {

/// The option that keeps a loop open, for a summary: "more edges than fill.max_edges"; empty where
/// no option does.
const char* text_of(OpenReason reason);

/// "file", "estimated" or "poles"; empty for kAuto: not decided.
const char* text_of(NormalSource source);
/// "scanner", "viewpoint", "up", "propagate", "ground", "inward" or "none"; empty for kAuto: the
/// file's.
const char* text_of(Orientation orientation);

/// The reverse of text_of; kAuto for any other text.
NormalSource normal_source_from(std::string_view text);
Orientation orientation_from(std::string_view text);

}  // namespace orbweave
