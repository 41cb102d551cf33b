#include "engine/run_job.h"

#include <memory>

#include "engine/pipeline/pipeline.h"

namespace orbweave {

RunReport run_job(const Job& job, const RunJobOptions& options) {
  const std::unique_ptr<Progress> silent = make_progress(ProgressStyle::kSilent);
  const StopToken never;
  return run_job(job, options.command, options.progress != nullptr ? *options.progress : *silent,
                 options.stop != nullptr ? *options.stop : never);
}

}  // namespace orbweave
