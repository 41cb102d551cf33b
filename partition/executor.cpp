#include "partition/executor.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <deque>
#include <exception>
#include <mutex>
#include <optional>

namespace orbweave {
namespace {

/// Hands tasks out in order as memory allows; one object per run_chunks.
class Dispatcher {
 public:
  Dispatcher(std::span<const ChunkTask> tasks, const ExecutorOptions& options, int threads,
             const std::function<void(ChunkId)>& work)
      : tasks_(tasks), options_(options), threads_(threads), work_(work) {}

  /// Returns when every task that was started has ended; rethrows the failure of the first
  /// failed task in task order.
  void run() {
    start_tasks();
    group_.wait();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  bool fits(const ChunkTask& task) const {
    if (in_flight_ == 0) return true;
    // Never overflows: each summand was admitted below the budget, or runs alone.
    return options_.memory_bytes == 0 || (memory_ <= options_.memory_bytes &&
                                          task.memory_bytes <= options_.memory_bytes - memory_);
  }

  void start_tasks() {
    const std::scoped_lock lock(mutex_);
    while (!failure_ && in_flight_ < threads_ && has_next() && fits(tasks_[next_])) {
      ++in_flight_;
      memory_ += tasks_[next_].memory_bytes;
      ready_.push_back(next_);
      taken_ = false;
      // The scheduler may run these in any order; which task it is, the queue decides.
      group_.run([this] { run_one(); });
    }
  }

  /// Makes next_ the task to start next. Whoever takes a number from the team keeps it until its
  /// task fits.
  bool has_next() {
    if (!taken_ && next_ < tasks_.size()) {
      next_ = options_.team == nullptr ? alone_++ : options_.team->take_next();
      taken_ = true;
    }
    return next_ < tasks_.size();
  }

  void run_one() {
    const std::optional<std::size_t> index = take_ready();
    if (!index) return;
    try {
      if (options_.stop != nullptr) options_.stop->check();
      // Without isolation a thread that waits inside `work` could pick up another chunk.
      tbb::this_task_arena::isolate([&] { work_(tasks_[*index].chunk); });
    } catch (...) {
      fail(*index, std::current_exception());
    }
    {
      const std::scoped_lock lock(mutex_);
      --in_flight_;
      memory_ -= tasks_[*index].memory_bytes;
    }
    start_tasks();
  }

  /// Empty when a failure has cancelled what had not begun.
  std::optional<std::size_t> take_ready() {
    const std::scoped_lock lock(mutex_);
    if (failure_ || ready_.empty()) return std::nullopt;
    const std::size_t index = ready_.front();
    ready_.pop_front();
    return index;
  }

  void fail(std::size_t index, std::exception_ptr failure) {
    const std::scoped_lock lock(mutex_);
    if (failure_ && failed_index_ <= index) return;
    failure_ = std::move(failure);
    failed_index_ = index;
  }

  std::span<const ChunkTask> tasks_;
  const ExecutorOptions& options_;
  const int threads_;
  const std::function<void(ChunkId)>& work_;

  std::mutex mutex_;
  std::size_t next_ = 0;   // the task that was taken, where taken_; at the end: past the last
  std::size_t alone_ = 0;  // counts tasks where no team does
  bool taken_ = false;
  std::deque<std::size_t> ready_;  // admitted, not yet picked up by a thread
  int in_flight_ = 0;              // admitted, not yet ended
  std::size_t memory_ = 0;         // of those
  std::exception_ptr failure_;
  std::size_t failed_index_ = 0;
  tbb::task_group group_;
};

}  // namespace

void StopToken::check() const {
  if (requested())
    throw Error(ExitStatus::kInterrupted, "interrupted; what is done is kept",
                {.advice = "The same command resumes"});
}

int available_threads() { return tbb::info::default_concurrency(); }

void run_chunks(std::span<const ChunkTask> tasks, const ExecutorOptions& options,
                const std::function<void(ChunkId)>& work) {
  const int threads = options.threads > 0 ? options.threads : available_threads();
  // TBB caps an arena at the number of cores; who asks for more threads shall have them.
  std::optional<tbb::global_control> more_threads;
  if (threads > available_threads())
    more_threads.emplace(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  arena.execute([&] { Dispatcher(tasks, options, threads, work).run(); });
}

}  // namespace orbweave
