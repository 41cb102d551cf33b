// What a run is at, as a document in its work directory: a line of JSON per step that began. The
// run writes it, `orbweave status` reads it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "io/report/progress.h"

namespace orbweave {

/// The document in the work directory.
inline constexpr const char* kStepsName = "orbweave-steps.jsonl";

struct RunStep {
  std::string name;         ///< as the table of stages has it
  std::uint64_t total = 0;  ///< work of the step; 0: not known
};

/// Passes everything on to `shown` (which must outlive it) and appends a line per step to `file`. A
/// document that cannot be written is no reason to stop: the job goes on without.
std::unique_ptr<Progress> make_recorded_progress(std::unique_ptr<Progress> shown,
                                                 const std::filesystem::path& file);

/// The step that began last; empty where no run wrote one. Lines that are not whole are passed
/// over.
std::optional<RunStep> last_step(const std::filesystem::path& file);

}  // namespace orbweave
