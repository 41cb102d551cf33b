// A job's progress, kept: what a person sees also goes to a log file with dates, for the morning
// after a long night.
#pragma once

#include <filesystem>
#include <memory>

#include "io/report/progress.h"

namespace orbweave {

/// Passes everything on to `shown` (which must outlive it) and appends a line per stage, note and
/// warning to `file`. Empty: there is no file. A log that cannot be written is no reason to stop:
/// the job goes on without.
std::unique_ptr<Progress> make_logged_progress(Progress& shown, const std::filesystem::path& file);

}  // namespace orbweave
