// What a run is at, as a document in its work directory: a line of JSON per step that began or
// ended, with the time. The run writes it, `orbweave status` reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "io/report/job_pace.h"
#include "io/report/progress.h"

namespace orbweave {

/// The document in the work directory.
inline constexpr const char* kStepsName = "orbweave-steps.jsonl";

struct RunStep {
  std::string name;         ///< as the table of stages has it
  std::uint64_t total = 0;  ///< work of the step; 0: not known
};

/// Seconds of the clock that the document has, the same for all programs.
double run_clock_seconds();

/// Passes everything on to `shown` (which must outlive it) and appends a line per step to `file`. A
/// document that cannot be written is no reason to stop: the job goes on without.
std::unique_ptr<Progress> make_recorded_progress(std::unique_ptr<Progress> shown,
                                                 const std::filesystem::path& file);

/// What the document tells of the last run.
struct RunSteps {
  RunStep last;  ///< that began last; without a name where none did
  JobPace pace;  ///< by run_clock_seconds()
};

/// Lines that are not whole are passed over.
RunSteps stored_steps(const std::filesystem::path& file);

}  // namespace orbweave
