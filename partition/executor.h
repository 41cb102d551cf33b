// Runs a stage over chunks: loading and storing overlap with computing, as many chunks in flight
// as the memory budget allows, and no result depends on who finished first.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "io/chunk_store.h"
#include "partition/team.h"

namespace orbweave {

/// Set by a signal handler, polled by loops. Interrupted work throws Interrupted.
class StopToken {
 public:
  void request() { stop_.store(true, std::memory_order_relaxed); }
  bool requested() const { return stop_.load(std::memory_order_relaxed); }
  /// Throws Error with ExitStatus::kInterrupted when requested.
  void check() const;

 private:
  std::atomic<bool> stop_{false};
};

struct ExecutorOptions {
  int threads = 0;               ///< worker threads; 0: all the machine has
  std::size_t memory_bytes = 0;  ///< budget of all chunks in flight; 0: no limit
  const StopToken* stop = nullptr;
  /// Shares the tasks with the other members, who were given the same ones in the same order and
  /// called start_counting() before; null: all tasks are this process's.
  Team* team = nullptr;
  /// What the whole process may hold; 0: not watched. Chunks that hold more than was planned make
  /// the plan of the following ones larger, and none starts while memory is short.
  std::uint64_t process_bytes = 0;
  /// What the process holds; empty: as the system says.
  std::function<std::uint64_t()> resident = {};
};

/// One chunk's work on its way through a stage.
struct ChunkTask {
  ChunkId chunk = 0;
  std::size_t memory_bytes = 0;  ///< what it will hold at its peak
};

/// Calls work(chunk) for every task. Tasks start in the order given as memory allows (a task
/// larger than the budget runs alone); inside `work`, TBB algorithms use the same threads, so a
/// single large chunk is computed by all of them. The first exception stops the rest and is
/// rethrown after all running tasks ended.
void run_chunks(std::span<const ChunkTask> tasks, const ExecutorOptions& options,
                const std::function<void(ChunkId)>& work);

/// Number of threads that `threads` = 0 means.
int available_threads();

}  // namespace orbweave
