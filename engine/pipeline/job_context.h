// What the stages of a job are given, and how they are measured.
#pragma once

#include <string>
#include <vector>

#include "io/chunk_store.h"
#include "io/job.h"
#include "io/progress.h"
#include "io/report.h"
#include "partition/executor.h"

namespace orbweave {

/// What reading the input takes.
struct InputContext {
  const Job& job;
  const std::vector<std::string>& files;  ///< after globbing
  Progress& progress;
  const StopToken& stop;

  int threads() const { return job.run.threads > 0 ? job.run.threads : available_threads(); }
};

/// What every stage shares.
struct JobContext : InputContext {
  ChunkStore& store;
  RunReport& report;

  void note(const std::string& line) {
    report.notes.push_back(line);
    progress.note(line);
  }
  void warn(const std::string& line) {
    report.notes.push_back(line);
    progress.warn(line);
  }
};

/// Measures one stage and tells the progress display about it; the facts go to the report when
/// the object dies.
class StageClock {
 public:
  StageClock(JobContext& context, const std::string& name, std::uint64_t total,
             const std::string& unit);
  ~StageClock();
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  StageFacts& facts() { return facts_; }

 private:
  JobContext& context_;
  StageFacts facts_;
  double wall_begin_;
  double cpu_begin_;
  std::uint64_t read_begin_;
  std::uint64_t written_begin_;
};

}  // namespace orbweave
