// Jobs that are run again, and what the second run says.
#pragma once

#include <string>
#include <vector>

#include "engine/pipeline/pipeline.h"
#include "tests/support/clouds.h"
#include "tests/support/data.h"
#include "tests/support/jobs.h"

namespace orbweave::test {

struct Told {
  RunReport report;
  std::vector<std::string> lines;

  const StageFacts* stage(const std::string& name) const {
    for (const StageFacts& facts : report.stages)
      if (facts.name == name) return &facts;
    return nullptr;
  }
  /// The lines with these words.
  std::string says(const std::string& words) const {
    std::string text;
    for (const std::string& line : lines)
      if (line.find(words) != std::string::npos) text += line + "\n";
    return text;
  }
  /// The lines that say what is computed again.
  std::string again() const { return says("computed again"); }
};

inline Told run_told(const Job& job) {
  RecordingProgress progress;
  const StopToken stop;
  Told told;
  told.report = run_job(job, {"test"}, progress, stop);
  told.lines = progress.lines;
  return told;
}

/// A job that has run and whose work directory is kept.
inline Job kept_job(const ScratchDirectory& scratch) {
  Job job = job_for(scratch, painted_torus(3000, 0.3, 31));
  job.partition.chunk_points = 400;
  job.run.keep_work_dir = true;
  run(job);
  return job;
}

/// The bytes of the mesh of the same job without anything to take over.
inline std::string without_work(const Job& job) {
  Job alone = job;
  alone.run.work_dir += ".alone";
  alone.output.mesh += ".alone.ply";
  return mesh_bytes(alone);
}

}  // namespace orbweave::test
