// Other threads of Python run while one works in the library, and the interpreter does not end in
// the middle of that work.
#pragma once

#include <pybind11/pybind11.h>

#include <atomic>

#include "io/stop_token.h"

namespace orbweave::python {

/// Releases the interpreter's lock for its lifetime. Once the interpreter ends the lock is kept: a
/// thread without it could not come back. The caller holds the lock.
class OthersMayRun {
 public:
  OthersMayRun();
  ~OthersMayRun();
  OthersMayRun(const OthersMayRun&) = delete;
  OthersMayRun& operator=(const OthersMayRun&) = delete;

 private:
  PyThreadState* thread_ = nullptr;  ///< of the caller; null where the lock is kept
};

/// Work of the library in a thread of its own, from before the thread begins until it has ended.
/// Such work is asked to stop when the interpreter ends.
class WorkBeside {
 public:
  explicit WorkBeside(StopToken& stop);
  ~WorkBeside();
  WorkBeside(const WorkBeside&) = delete;
  WorkBeside& operator=(const WorkBeside&) = delete;

  /// The work has ended. For its thread, which needs no lock for this.
  void end() { has_ended_.store(true, std::memory_order_release); }
  bool has_ended() const { return has_ended_.load(std::memory_order_acquire); }
  void stop() { stop_.request(); }

 private:
  StopToken& stop_;
  std::atomic<bool> has_ended_{false};
};

/// Whether the interpreter ends, and this thread with it: what is called in the last thread even
/// then (atexit) is done. The caller holds the lock.
bool is_to_end();

/// Lets the interpreter wait at its end until nothing of the module works. For the module's
/// beginning.
void wait_for_work_at_exit();

}  // namespace orbweave::python
