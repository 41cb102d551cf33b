// The stages in order, resumable: scan files in, one mesh file out.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline/stage/resolved_job.h"
#include "io/job/job.h"
#include "io/report/job_pace.h"
#include "io/report/progress.h"
#include "io/report/report.h"
#include "partition/executor.h"

namespace orbweave {

/// Runs a job to its end: mesh, report and picture are written, the work directory is removed
/// (unless kept). Throws Error; on interruption or failure everything committed stays in the
/// work directory and the same call resumes.
RunReport run_job(const Job& job, const std::vector<std::string>& command, Progress& progress,
                  const StopToken& stop);

/// What a caller learns of a run that is going on, also where it ends by an error.
struct RunWatch {
  bool work_dir_is_opened = false;
  bool work_dir_is_made = false;                  ///< by the program, in this run or an earlier one
  std::function<void()> at_mesh_written = {};     ///< it is whole, other outputs are to follow
  std::function<void()> at_outputs_written = {};  ///< the work directory is about to go
};

/// The same by several processes, each of which calls it with the same job; `memory` and `threads`
/// count for each. The leader's report is that of the job.
RunReport run_job(const Job& job, const std::vector<std::string>& command, Progress& progress,
                  const StopToken& stop, Communicator& communicator, RunWatch* watch = nullptr);

/// What a work directory says about the run that uses or used it.
struct StageStatus {
  std::string name;
  std::uint64_t chunks_done = 0;       ///< committed
  std::uint64_t chunks_in_flight = 0;  ///< written, and not yet committed
  std::uint64_t chunks_total = 0;      ///< 0: not known yet
  bool done = false;
};
struct WorkStatus {
  std::vector<StageStatus> stages;
  bool running = false;  ///< a process holds the lock
  int process_id = 0;    ///< that holds the lock, or held it last; 0: not known
  /// Of the team of the run, or of the last one where they outlived it: "rank 1 (process 7 on x)".
  std::vector<std::string> members;
  std::string step;    ///< what the run is at, or was at last: "sort"
  bool ended = false;  ///< all outputs are written
  /// Of the run that is going on, from what its stages typically take; empty: not known yet.
  std::optional<JobPace::Estimate> pace;
  std::string last_touched;  ///< ISO 8601, UTC
};
/// Throws Error (usage) where the directory is no work directory.
WorkStatus work_status(const std::filesystem::path& work_dir);

}  // namespace orbweave
