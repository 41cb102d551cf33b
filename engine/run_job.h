// A job from a program: scan files in, a mesh file out, resumable, in bounded memory.
#pragma once

#include <string>
#include <vector>

#include "io/error.h"
#include "io/job/job.h"
#include "io/report/progress.h"
#include "io/report/report.h"
#include "io/stop_token.h"

namespace orbweave {

struct RunJobOptions {
  /// Is told what goes on, by any thread; has to outlive the call. Default: null, silent.
  Progress* progress = nullptr;
  /// Requested: the run ends with an Error (interrupted); has to outlive the call. Default: null.
  const StopToken* stop = nullptr;
  std::vector<std::string> command;  ///< for the report: how the run was called; may be empty
};

/// Runs a job to its end, as `orbweave run` does: the mesh, the report and the picture are written,
/// the work directory is removed (unless it is to be kept). Throws Error: usage where no scan is
/// named and for a number that job files do not accept (`orbweave config --reference`); after an
/// interruption or a full disk the same call resumes from the work directory.
///
/// For one thread at a time: `partition.memory_bytes` bounds the process, and two jobs at once
/// would count each other's memory.
RunReport run_job(const Job& job, const RunJobOptions& options = {});

}  // namespace orbweave
