// The processes that work on one job together. All of them run the same stages in the same order;
// the chunks of a stage are dealt out by a common counter, what is not worth dealing out is done
// by the leader while the others wait. Results pass through the chunk store alone.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace orbweave {

class StopToken;

/// A team of one: what a job has unless it is told otherwise. partition/mpi_team.h has the other.
class Team {
 public:
  Team() = default;
  virtual ~Team() = default;
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  virtual int rank() const { return 0; }
  virtual int size() const { return 1; }
  bool leads() const { return rank() == 0; }
  /// Threads that a member takes where the job leaves that open, so that members on one machine
  /// do not compete for its cores; 0: all it has.
  virtual int threads() const { return 0; }

  /// Returns when every member has called it. Throws Error (interrupted) when `stop` is requested
  /// meanwhile.
  void meet(const StopToken& stop) {
    meet(stop, [] {});
  }
  /// The same; calls `while_waiting` some times a second meanwhile, by the calling thread.
  virtual void meet(const StopToken& /*stop*/, const std::function<void()>& /*while_waiting*/) {}

  /// Returns the leader's `word` to everybody; includes a meeting.
  virtual std::uint64_t leaders_word(std::uint64_t word, const StopToken& /*stop*/) { return word; }

  /// Sets the common counter to 0 for everybody; includes a meeting.
  virtual void start_counting(const StopToken& /*stop*/) { counter_ = 0; }
  /// The counter's value, which then rises by one: every number goes to one member alone.
  /// Thread-safe.
  virtual std::uint64_t take_next() { return counter_++; }

  /// For the one progress line: adds to what all members have done since start_counting().
  /// Thread-safe.
  virtual void add_done(std::uint64_t /*units*/, std::uint64_t /*points*/) {}
  /// What the others have done since the leader asked last. Only the leader asks.
  struct Done {
    std::uint64_t units = 0;
    std::uint64_t points = 0;
  };
  virtual Done done_by_others() { return {}; }

 private:
  std::atomic<std::uint64_t> counter_{0};
};

}  // namespace orbweave
