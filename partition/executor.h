// Runs a stage over chunks: loading and storing overlap with computing, as many chunks in flight
// as the memory budget allows, and no result depends on who finished first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "io/stop_token.h"
#include "io/store/chunk_store.h"
#include "partition/communicator.h"

namespace orbweave {

struct ExecutorOptions {
  int threads = 0;               ///< worker threads; 0: all the machine has
  std::size_t memory_bytes = 0;  ///< budget of all chunks in flight; 0: no limit
  const StopToken* stop = nullptr;
  /// Shares the tasks with the other processes, who were given the same ones in the same order and
  /// called reset_counter() before; null: all tasks are this process's.
  Communicator* communicator = nullptr;
  /// Threads that a process has, about; the same number in every process. Sizes of the blocks that
  /// the common counter gives out follow from it (partition/task_shares.h).
  int threads_of_each = 1;
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
  std::uint64_t length = 1;      ///< how long it takes, compared with the others
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
