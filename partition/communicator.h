// The processes that work on one job together. All of them run the same stages in the same order;
// the chunks of a stage are dealt out by a common counter, what is not worth dealing out is done
// by the root while the others wait. Results pass through the chunk store alone.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace orbweave {

class StopToken;

/// A communicator of one process: what a job has unless it is told otherwise.
/// partition/mpi_communicator.h has the other.
class Communicator {
 public:
  Communicator() = default;
  virtual ~Communicator() = default;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }
  bool is_root() const { return rank() == 0; }
  /// Threads that a process takes where the job leaves that open, so that processes on one machine
  /// do not compete for its cores; 0: all it has.
  virtual int threads() const { return 0; }

  /// Returns when every process has called it. Throws Error (interrupted) when `stop` is requested
  /// meanwhile.
  void barrier(const StopToken& stop) {
    barrier(stop, [] {});
  }
  /// A barrier that calls `while_waiting` some times a second meanwhile, by the calling thread.
  virtual void barrier(const StopToken& /*stop*/, const std::function<void()>& /*while_waiting*/) {}

  /// Returns the root's `word` to every process; includes a barrier.
  virtual std::uint64_t broadcast(std::uint64_t word, const StopToken& /*stop*/) { return word; }

  /// Sets the common counter to 0 for every process; includes a barrier.
  virtual void reset_counter(const StopToken& /*stop*/) { counter_ = 0; }
  /// The counter's value, which then rises by `amount`: every number goes to one process alone.
  /// Thread-safe.
  std::uint64_t fetch_next(std::uint64_t amount = 1);
  /// Calls of fetch_next() by this process.
  std::uint64_t counter_calls() const { return counter_calls_; }
  /// What the shortest of them took: the others waited for calls of other processes; 0 before the
  /// first.
  double counter_seconds() const { return counter_calls_ > 0 ? counter_seconds_.load() : 0.0; }

  /// Returns every process's text to the root, by rank, and nothing to the others; includes a
  /// barrier.
  virtual std::vector<std::string> gather(const std::string& text, const StopToken& /*stop*/) {
    return {text};
  }

  /// For the one progress line: adds to what all processes have done since reset_counter().
  /// Thread-safe.
  virtual void add_done(std::uint64_t /*units*/, std::uint64_t /*points*/) {}
  /// What the others have done since the root asked last. Only the root asks.
  struct Done {
    std::uint64_t units = 0;
    std::uint64_t points = 0;
  };
  virtual Done done_by_others() { return {}; }

 protected:
  virtual std::uint64_t count_up(std::uint64_t amount) { return counter_.fetch_add(amount); }

 private:
  std::atomic<std::uint64_t> counter_{0};
  std::atomic<std::uint64_t> counter_calls_{0};
  std::atomic<double> counter_seconds_{std::numeric_limits<double>::infinity()};
};

}  // namespace orbweave
