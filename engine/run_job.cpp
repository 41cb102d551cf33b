#include "engine/run_job.h"

#include <memory>

#include "engine/pipeline/pipeline.h"
#include "io/job/job_file.h"

namespace orbweave {
namespace {

/// A job that a program filled in was held to no range yet.
void check_job(const Job& job) {
  if (job.input.files.empty())
    throw_usage("names no scans", {.place = "input.files", .expected = "at least one path"});
  if (job.output.mesh.empty())
    throw_usage("names no mesh to write", {.place = "output.mesh", .expected = "a path"});
  check_job_numbers(job);
}

}  // namespace

RunReport run_job(const Job& job, const RunJobOptions& options) {
  check_job(job);
  const std::unique_ptr<Progress> silent = make_progress(ProgressStyle::kSilent);
  const StopToken never;
  return run_job(job, options.command, options.progress != nullptr ? *options.progress : *silent,
                 options.stop != nullptr ? *options.stop : never);
}

}  // namespace orbweave
