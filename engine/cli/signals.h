// Signals that end a program become a request to stop; nothing else happens in a handler.
#pragma once

#include <signal.h>

#include <array>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "partition/executor.h"

namespace orbweave {

/// The signals of a user, and those by which batch systems announce that a job's time is over.
inline constexpr std::array kStopSignals = {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1, SIGUSR2};

/// From now on kStopSignals set `stop`, which must outlive the process's main(), unless they are
/// ignored already; a second one ends the process at once with status 130. So does
/// a second's wait: work that has not ended by then is left as it is, as a kill would leave it,
/// temporaries of outputs are removed, and the last word is said. SIGPIPE is ignored, so that
/// writing to a closed pipe is an error that gets reported.
void handle_signals(StopToken& stop);

/// What a process says that leaves a second after the first signal; as an error is shown, without
/// colour. Empty: nothing.
void set_last_word(const std::string& what);

/// For commands that cannot resume: a file has its name and stays, whatever comes. From now on an
/// interruption says so.
void note_written(const std::string& path);

/// What an interruption of such a command says: that nothing was written, or what was.
std::string interruption();

/// The work is over, well or not: what is said from now on is the result, and no alarm of a signal
/// that came before ends the process.
void end_interruptible_work();

/// For commands that leave nothing behind: from now on the first signal ends the process.
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

/// For commands that cannot resume: throws Error (interrupted) when `stop` is requested, which says
/// what was written.
void check_interruption(const StopToken& stop);

}  // namespace orbweave
