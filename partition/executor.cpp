#include "partition/executor.h"

#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <vector>

#include "io/system/memory_watch.h"
#include "io/system/process_times.h"
#include "partition/allowed_threads.h"
#include "partition/task_shares.h"

namespace orbweave {
namespace {

/// Compares what chunks hold with what was planned for them. Decides when they start, never what
/// comes of them.
class MemoryGate {
 public:
  explicit MemoryGate(const ExecutorOptions& options)
      : limit_(options.process_bytes), resident_(options.resident) {
    if (limit_ == 0) return;
    if (!resident_) watch_.emplace();
    base_ = resident();
  }

  /// Whether another chunk may start beside some that hold `planned` bytes between them.
  bool admits(std::size_t planned, std::size_t next) {
    if (limit_ == 0) return true;
    learn();
    if (exceeds(base_, planned + next)) return false;
    if (!exceeds(resident(), next)) return true;
    // What the allocator keeps of ended chunks counts as held, though the next may have it.
    release_freed_memory();
    return !exceeds(resident(), next);
  }
  void started(std::size_t planned) { most_planned_ = std::max(most_planned_, planned); }
  void ended() {
    if (limit_ != 0) learn();
  }

 private:
  std::uint64_t resident() const { return resident_ ? resident_() : resident_bytes(); }
  bool exceeds(std::uint64_t held, std::size_t more) const {
    return static_cast<double>(held) + cost_ * static_cast<double>(more) >
           static_cast<double>(limit_);
  }
  /// The most that was held over the most that was planned at one time: memory that is kept for
  /// later does not make a chunk look costly.
  void learn() {
    // Less than that says more about the allocator than about chunks.
    constexpr std::size_t kTelling = std::size_t{32} << 20;
    peak_ = std::max(peak_, watch_ ? watch_->peak_bytes() : resident());
    if (most_planned_ < kTelling || peak_ < base_) return;
    cost_ =
        std::max(cost_, static_cast<double>(peak_ - base_) / static_cast<double>(most_planned_));
  }

  std::uint64_t limit_;
  std::function<std::uint64_t()> resident_;
  std::optional<MemoryWatch> watch_;
  std::uint64_t base_ = 0;  // before the first chunk
  std::uint64_t peak_ = 0;
  std::size_t most_planned_ = 0;
  double cost_ = 1.0;  // bytes held per byte planned, never less than 1
};

/// The tasks that this process takes, in ascending order: all of them, or those that it has by its
/// number and then those that the common counter gives it. Not thread-safe.
class TaskCounter {
 public:
  TaskCounter(std::span<const ChunkTask> tasks, const ExecutorOptions& options)
      : communicator_(options.communicator),
        shares_(lengths_of(tasks), communicator_ == nullptr ? 1 : communicator_->size(),
                options.threads_of_each),
        begin_seconds_(steady_seconds()) {
    if (communicator_ != nullptr && communicator_->size() == 1) communicator_ = nullptr;
    if (communicator_ == nullptr) {
      own_.end = seen_ = shares_.tasks();
      return;
    }
    own_ = shares_.by_number(communicator_->rank());
    seen_ = shares_.first_counted();
    length_ = shares_.length(own_);
  }

  /// The next task; the number of all tasks where none is left.
  std::size_t take() {
    if (own_.begin == own_.end && seen_ < shares_.tasks()) take_block();
    return own_.begin < own_.end ? own_.begin++ : shares_.tasks();
  }

 private:
  static std::vector<std::uint64_t> lengths_of(std::span<const ChunkTask> tasks) {
    std::vector<std::uint64_t> lengths;
    lengths.reserve(tasks.size());
    for (const ChunkTask& task : tasks) lengths.push_back(task.length);
    return lengths;
  }

  void take_block() {
    const double wanted =
        length_worth_a_call(length_, steady_seconds() - begin_seconds_, communicator_->size(),
                            communicator_->counter_seconds());
    const std::size_t count = shares_.of_call(seen_, wanted, latest_length_);
    const std::size_t before = communicator_->fetch_next(count);
    own_.begin = std::min(shares_.first_counted() + before, shares_.tasks());
    own_.end = seen_ = std::min(own_.begin + count, shares_.tasks());
    latest_length_ = shares_.length(own_);
    length_ += latest_length_;
  }

  Communicator* communicator_;
  TaskShares shares_;
  double begin_seconds_;
  TaskRange own_;                    // taken, not yet begun
  std::size_t seen_ = 0;             // the first task that may be left
  std::uint64_t length_ = 0;         // of all that was taken
  std::uint64_t latest_length_ = 0;  // of the latest block from the counter
};

/// Hands tasks out in order as memory allows; one object per run_chunks.
class Dispatcher {
 public:
  Dispatcher(std::span<const ChunkTask> tasks, const ExecutorOptions& options, int threads,
             const std::function<void(ChunkId)>& work)
      : tasks_(tasks),
        options_(options),
        threads_(threads),
        work_(work),
        gate_(options),
        counter_(tasks, options) {}

  /// Returns when every task that was started has ended; rethrows the failure of the first
  /// failed task in task order.
  void run() {
    start_tasks();
    group_.wait();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  bool fits(const ChunkTask& task) {
    if (in_flight_ == 0) return true;
    // Never overflows: each summand was admitted below the budget, or runs alone.
    const bool planned =
        options_.memory_bytes == 0 ||
        (memory_ <= options_.memory_bytes && task.memory_bytes <= options_.memory_bytes - memory_);
    return planned && gate_.admits(memory_, task.memory_bytes);
  }

  void start_tasks() {
    const std::scoped_lock lock(mutex_);
    while (!failure_ && in_flight_ < threads_ && has_next() && fits(tasks_[next_])) {
      ++in_flight_;
      memory_ += tasks_[next_].memory_bytes;
      gate_.started(memory_);
      ready_.push_back(next_);
      taken_ = false;
      // The scheduler may run these in any order; which task it is, the queue decides.
      group_.run([this] { run_one(); });
    }
  }

  /// Makes next_ the task to start next. A process that takes a task from the counter keeps the
  /// task until it fits.
  bool has_next() {
    if (!taken_ && next_ < tasks_.size()) {
      next_ = counter_.take();
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
      gate_.ended();
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
  MemoryGate gate_;
  TaskCounter counter_;
  std::size_t next_ = 0;  // the task that was taken, where taken_; at the end: past the last
  bool taken_ = false;
  std::deque<std::size_t> ready_;  // admitted, not yet picked up by a thread
  int in_flight_ = 0;              // admitted, not yet ended
  std::size_t memory_ = 0;         // of those
  std::exception_ptr failure_;
  std::size_t failed_index_ = 0;
  tbb::task_group group_;
};

}  // namespace

int available_threads() { return tbb::info::default_concurrency(); }

void run_chunks(std::span<const ChunkTask> tasks, const ExecutorOptions& options,
                const std::function<void(ChunkId)>& work) {
  const int threads = options.threads > 0 ? options.threads : available_threads();
  tbb::task_arena arena(allowed_threads(threads));
  arena.execute([&] { Dispatcher(tasks, options, threads, work).run(); });
}

}  // namespace orbweave
