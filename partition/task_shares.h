// How the tasks of a stage are dealt out to the processes of a job: half of the work by the
// processes' numbers, the rest block by block by their common counter. Blocks shrink towards the
// end, where everybody waits for the last. Guided self-scheduling: Polychronopoulos and Kuck,
// Guided Self-Scheduling: A Practical Scheduling Scheme for Parallel Supercomputers, 1987. The
// counter serves one process after the other, hence blocks that are soon done are larger: Kruskal
// and Weiss, Allocating Independent Subtasks on Parallel Processors, 1985.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace orbweave {

/// Tasks [begin, end).
struct TaskRange {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Equal arguments give equal shares in every process.
class TaskShares {
 public:
  /// `lengths`: how long each task takes, compared with the others, the longest first. O(tasks).
  TaskShares(std::span<const std::uint64_t> lengths, int processes, int threads);

  /// What a process has by its number: tasks that follow each other, 1 / (2 processes) of the
  /// length, but `threads` tasks at least, or an equal share where there are fewer.
  TaskRange by_number(int rank) const;
  /// The first task that no process has by its number.
  std::size_t first_counted() const { return begins_.back(); }
  std::size_t tasks() const { return ends_.size() - 1; }
  /// Of tasks that follow each other.
  std::uint64_t length(TaskRange tasks) const { return ends_[tasks.end] - ends_[tasks.begin]; }

  /// How many tasks a process takes by its next call of the counter, at least one: those of the
  /// wanted length, if that is between 1 / (2 processes) and 1 / processes of what is left.
  /// `first`: the first task that may be left, as far as the process knows. `latest_length`: of the
  /// process's latest block from the counter, as which the others have taken theirs since; 0 before
  /// the first.
  std::size_t of_call(std::size_t first, double wanted_length, std::uint64_t latest_length) const;

 private:
  std::size_t processes_;
  std::vector<std::uint64_t> ends_;  // length of the tasks before each, and of all
  std::vector<std::size_t> begins_;  // of what each process has by its number, and the end
};

/// The length of a block that lasts as long as the counter takes to serve all processes twice.
/// `length`: that the process has taken so far, in so many seconds. `call_seconds`: of one call.
double length_worth_a_call(std::uint64_t length, double seconds, int processes,
                           double call_seconds);

}  // namespace orbweave
