// SIGINT and SIGTERM become a request to stop; nothing else happens in a handler.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "partition/executor.h"

namespace orbweave {

/// From now on SIGINT and SIGTERM set `stop`, which must outlive the process's main(); a second
/// one ends the process at once with status 130. SIGPIPE is ignored, so that writing to a closed
/// pipe is an error that gets reported.
void handle_signals(StopToken& stop);

/// For commands that leave nothing to clean up: from now on the first signal ends the process.
void end_at_once_on_signals();

/// The same while it lives: for what can take long and leaves nothing behind. Then signals are
/// requests to stop again.
class EndAtOnceOnSignals {
 public:
  EndAtOnceOnSignals();
  ~EndAtOnceOnSignals();
  EndAtOnceOnSignals(const EndAtOnceOnSignals&) = delete;
  EndAtOnceOnSignals& operator=(const EndAtOnceOnSignals&) = delete;

 private:
  StopToken* stop_;
};

/// Calls `say` once, on a thread of its own, where the process still has not ended some moments
/// after `stop` was requested: what is in flight is finished first. Says nothing after its end.
class StopNotice {
 public:
  StopNotice(const StopToken& stop, std::function<void()> say);
  ~StopNotice();
  StopNotice(const StopNotice&) = delete;
  StopNotice& operator=(const StopNotice&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable end_signal_;
  bool ended_ = false;
  std::thread watch_;
};

/// For commands that cannot resume: throws Error (interrupted) when `stop` is requested.
void check_interruption(const StopToken& stop);

}  // namespace orbweave
