// What the stages of a job are given, and how they are measured.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "io/chunk_store.h"
#include "io/job.h"
#include "io/memory_watch.h"
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
  Team& team;

  void note(const std::string& line) {
    report.notes.push_back(line);
    progress.note(line);
  }
  void warn(const std::string& line) {
    report.notes.push_back(line);
    progress.warn(line);
  }
};

/// A chunk's work in a stage.
struct ChunkWork {
  ChunkId chunk = 0;
  std::size_t memory_bytes = 0;  ///< held at its peak
  std::uint64_t length = 0;      ///< how long it takes, compared with the others
  std::uint64_t points = 0;      ///< counted for the rate
};

class StageClock;

/// Runs `work` for every chunk that `stage` lacks, by the whole team, the longest first, with at
/// most `memory_bytes` in flight in each process. Every member calls it with the same chunks;
/// when it returns, all results are durable and everybody sees them.
void share_chunks(JobContext& context, StageClock& clock, const std::string& stage,
                  std::vector<ChunkWork> chunks, std::size_t memory_bytes,
                  const std::function<void(ChunkId)>& work);

/// The leader does it, the others wait. What it leaves in the store, everybody sees afterwards.
void by_leader(JobContext& context, const std::function<void()>& work);

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
  MemoryWatch memory_;
  double wall_begin_;
  double cpu_begin_;
  std::uint64_t read_begin_;
  std::uint64_t written_begin_;
};

}  // namespace orbweave
