// A long call of the library from Python: the interpreter lives on, Ctrl-C stops the call, and what
// the call tells reaches a callback.
#pragma once

#include <pybind11/pybind11.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <string>

#include "io/stop_token.h"

namespace orbweave::python {

/// Watches one call. All of Python runs in the thread that called from Python; the work runs in a
/// thread of its own, without the interpreter's lock.
class WatchedCall {
 public:
  /// `progress`: called with the name of a stage and the share that is done, or None.
  explicit WatchedCall(pybind11::object progress) : progress_(std::move(progress)) {}

  /// Runs the work and waits for its end. Throws what the work throws; where a signal or the
  /// callback raised meanwhile, the work is stopped first, and that exception is thrown. The
  /// caller holds the interpreter's lock.
  void run(const std::function<void()>& work);

  // For the work, from any thread.
  const StopToken& stop() const { return stop_; }
  void tell(std::string stage, double done);
  void warn(std::string line);

 private:
  struct News {
    std::string text;
    double done = 0.0;
    bool is_warning = false;
  };

  void add(News news);
  /// Waits for news or the end, not for long; false at the end.
  bool wait(std::deque<News>& news);
  /// Throws what Python raises.
  void pass_on(const std::deque<News>& news);

  pybind11::object progress_;
  StopToken stop_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<News> news_;  ///< not yet passed on
  bool has_ended_ = false;
};

}  // namespace orbweave::python
