// A request to stop, as a signal makes it, and the looks that long loops take at it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace orbweave {

/// What an interruption says where nothing else is known of the work.
inline constexpr const char* kInterruptedText = "interrupted";

/// Set by a signal handler, polled by loops. Interrupted work throws Error (interrupted). Results
/// never depend on it. Thread-safe; one token may stop several calls. A request is never taken
/// back: the next call takes a new token.
class StopToken {
 public:
  /// May be called by any thread, any number of times, and by a signal handler.
  void request() { stop_.store(true, std::memory_order_relaxed); }
  bool requested() const { return stop_.load(std::memory_order_relaxed); }
  /// Throws Error with ErrorKind::kInterrupted and the text kInterruptedText when requested.
  void check() const;
  /// How often check() was called: tests tell from it how much work lies between two looks.
  std::uint64_t checks() const { return checks_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> stop_{false};
  mutable std::atomic<std::uint64_t> checks_{0};
};

/// Points, triangles or rows between two looks: some milliseconds of the slowest algorithm.
constexpr std::size_t kStopBlock = 4096;

/// Checks a token that may be null.
inline void check_stop(const StopToken* stop) {
  if (stop != nullptr) stop->check();
}

/// Checks a token, which may be null, after so many steps, and before the first. For loops whose
/// rounds differ in length.
class StopLooks {
 public:
  StopLooks(const StopToken* stop, std::uint64_t steps)
      : stop_(stop), every_(steps), unlooked_(steps) {}
  void after(std::uint64_t steps) {
    unlooked_ += steps;
    if (unlooked_ < every_) return;
    unlooked_ = 0;
    check_stop(stop_);
  }

 private:
  const StopToken* stop_;
  std::uint64_t every_;
  std::uint64_t unlooked_;
};

}  // namespace orbweave
