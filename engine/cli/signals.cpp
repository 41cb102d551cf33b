#include "engine/cli/signals.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <mutex>
#include <utility>

#include "engine/cli/exit_status.h"
#include "io/error.h"
#include "io/shown_text.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

std::atomic<StopToken*> token{nullptr};
static_assert(std::atomic<StopToken*>::is_always_lock_free &&
                  std::atomic<bool>::is_always_lock_free,
              "the handler may touch lock-free atomics only");

/// How long what is in flight may take to end in order after the first signal.
constexpr unsigned kPatienceSeconds = 1;

/// Read by the handler alone, once it is complete: written before `last_word_bytes` is.
std::array<char, 8192> last_word{};
std::atomic<std::size_t> last_word_bytes{0};

struct Written {
  std::mutex mutex;
  std::string names;
};

Written& written() {
  static Written all;
  return all;
}

[[noreturn]] void leave_at_once() {
  remove_temporaries_at_risk();
  _exit(static_cast<int>(ExitStatus::kInterrupted));
}

void on_signal(int) {
  StopToken* stop = token.load();
  if (stop == nullptr || stop->requested()) leave_at_once();
  stop->request();
  alarm(kPatienceSeconds);
}

/// The second is over. Every stage's results are made for a kill, so nothing is lost by leaving.
void on_end_of_patience(int) {
  const ssize_t ignored = write(STDERR_FILENO, last_word.data(), last_word_bytes.load());
  static_cast<void>(ignored);
  leave_at_once();
}

bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

void install(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;  // what is being read or written goes on to its next check
  sigaction(signal, &action, nullptr);
}

/// A signal that is ignored when the program begins stays ignored. Shells start background jobs of
/// scripts so (SIGINT), and so does nohup (SIGHUP).
void install_unless_ignored(int signal, void (*handler)(int)) {
  if (!is_ignored(signal)) install(signal, handler);
}

}  // namespace

std::string interruption() {
  const std::scoped_lock lock(written().mutex);
  const std::string& names = written().names;
  return "interrupted; " + (names.empty() ? "nothing was written" : "written so far: " + names);
}

void handle_signals(StopToken& stop) {
  token.store(&stop);
  set_last_word(interruption());
  for (const int signal : kStopSignals) install_unless_ignored(signal, on_signal);
  install(SIGALRM, on_end_of_patience);
  install(SIGPIPE, SIG_IGN);
  install(SIGXFSZ, SIG_IGN);  // a file beyond the limit of its size fails as on a full disk
}

void set_last_word(const std::string& what) {
  last_word_bytes.store(0);
  if (what.empty()) return;
  // A line that shows progress is written over.
  const std::string line =
      (isatty(STDERR_FILENO) == 1 ? "\r\033[K" : "") + ("orbweave: error: " + what) + "\n";
  if (line.size() > last_word.size()) return;
  std::copy(line.begin(), line.end(), last_word.begin());
  last_word_bytes.store(line.size());
}

void note_written(const std::string& path) {
  {
    const std::scoped_lock lock(written().mutex);
    std::string& names = written().names;
    names += (names.empty() ? "" : ", ") + shown(path);
  }
  set_last_word(interruption());
}

void end_interruptible_work() {
  set_last_word("");
  install(SIGALRM, SIG_IGN);
  alarm(0);
}

void end_at_once_on_signals() { token.store(nullptr); }

EndAtOnceOnSignals::EndAtOnceOnSignals() : stop_(token.exchange(nullptr)) {
  // A request that came before would not be looked at.
  if (stop_ != nullptr && stop_->requested()) leave_at_once();
}
EndAtOnceOnSignals::~EndAtOnceOnSignals() { token.store(stop_); }

StopNotice::StopNotice(const StopToken& stop, std::function<void()> say)
    : watch_([this, &stop, say = std::move(say)] {
        constexpr std::chrono::milliseconds kInterval{50};
        constexpr int kPatience = 6;  // intervals
        std::unique_lock lock(mutex_);
        for (int asked = 0; asked < kPatience; asked += stop.requested() ? 1 : 0) {
          if (end_signal_.wait_for(lock, kInterval, [this] { return ended_; })) return;
        }
        say();
      }) {}

StopNotice::~StopNotice() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  end_signal_.notify_all();
  watch_.join();
}

void check_interruption(const StopToken& stop) {
  if (stop.requested()) throw Error(ErrorKind::kInterrupted, interruption());
}

}  // namespace orbweave
