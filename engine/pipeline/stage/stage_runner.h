// What runs the stages of a job: communicator, store, clock and progress, and what the run said and
// measured so far.
#pragma once

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "engine/pipeline/stage/resolved_job.h"
#include "engine/pipeline/stage/said_line.h"
#include "engine/pipeline/stage/stages.h"
#include "io/report/progress.h"
#include "io/report/report.h"
#include "io/store/chunk_store.h"
#include "io/system/memory_watch.h"
#include "partition/executor.h"

namespace orbweave {

/// What a pass over the input takes: the job, who watches it, who may stop it.
struct RunControl {
  const ResolvedJob& job;
  Progress& progress;
  const StopToken& stop;

  int threads() const { return job.threads(); }
};

/// Every stage is a function `Result stage(const Inputs&, StageRunner&)`.
struct StageRunner : RunControl {
  ChunkStore& store;
  Communicator& communicator;
  int root_threads = 1;                    ///< of the root, as all processes know them
  std::vector<std::string> notes = {};     ///< everything said so far
  std::vector<std::string> warnings = {};  ///< of it, what was a warning
  std::vector<SaidLine> of_points = {};    ///< of it, what is stored with the points
  std::vector<StageFacts> measured = {};   ///< of the stages that ended
  /// What the points depend on and an earlier run had otherwise, in words; the leader's alone.
  std::string change_of_points = {};

  void note(const std::string& line) { note(line, line); }
  /// `line` is shown; the report has `full`. Once: an attempt before, which damage ended, may have
  /// come to it.
  void note(const std::string& line, const std::string& full) {
    if (std::find(notes.begin(), notes.end(), full) != notes.end()) return;
    notes.push_back(full);
    progress.note(line);
  }
  void warn(const std::string& line) { warn(line, line); }
  /// Once, as notes.
  void warn(const std::string& line, const std::string& full) {
    if (std::find(warnings.begin(), warnings.end(), full) != warnings.end()) return;
    notes.push_back(full);
    warnings.push_back(full);
    progress.warn(line);
  }
  /// Says what is true of the points, once: an earlier attempt of this run may have said it.
  void say_of_points(const SaidLine& line) {
    of_points.push_back(line);
    if (std::find(notes.begin(), notes.end(), line.full) != notes.end()) return;
    line.is_warning ? warn(line.shown, line.full) : note(line.shown, line.full);
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

/// Whether the results of a stage are durable when the stage ends.
enum class Durability {
  kAwaited,
  /// A process alone goes on while its results are flushed. Results become durable in the order of
  /// their commits, so a later wait is one for these, too.
  kFollows,
};

/// Runs `work` for every chunk that `stage` lacks, by the whole team, the longest first, with at
/// most `memory_bytes` in flight in each process. Every member calls it with the same chunks;
/// when it returns, everybody sees all results, and unless `durability` says otherwise they are
/// durable.
void share_chunks(StageRunner& runner, StageClock& clock, const std::string& stage,
                  std::vector<ChunkWork> chunks, std::size_t memory_bytes,
                  const std::function<void(ChunkId)>& work,
                  Durability durability = Durability::kAwaited);

/// What this process committed becomes visible to the others. A process alone sees it already.
void show_commits(StageRunner& runner);

/// The leader does the work, the others wait. Everybody sees afterwards what the leader left in the
/// store.
void by_root(StageRunner& runner, const std::function<void()>& work);

/// Measures one stage and tells the progress display about it. The facts go to the runner when the
/// object dies.
class StageClock {
 public:
  StageClock(StageRunner& runner, Stage stage, std::uint64_t total, const std::string& unit);
  /// Of a stage that runs several times, under the name of its directory.
  StageClock(StageRunner& runner, const std::string& name, std::uint64_t total,
             const std::string& unit);
  ~StageClock();
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  StageFacts& facts() { return facts_; }

 private:
  StageRunner& runner_;
  StageFacts facts_;
  MemoryWatch memory_;
  double wall_begin_;
  double cpu_begin_;
  std::uint64_t read_begin_;
  std::uint64_t written_begin_;
  std::uint64_t calls_begin_;
};

}  // namespace orbweave
