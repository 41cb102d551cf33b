#include "engine/cli/signals.h"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <utility>

#include "io/error.h"

namespace orbweave {
namespace {

std::atomic<StopToken*> token{nullptr};
static_assert(std::atomic<StopToken*>::is_always_lock_free &&
                  std::atomic<bool>::is_always_lock_free,
              "the handler may touch lock-free atomics only");

void on_signal(int) {
  StopToken* stop = token.load();
  if (stop == nullptr || stop->requested()) _exit(static_cast<int>(ExitStatus::kInterrupted));
  stop->request();
}

void install(int signal, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;  // what is being read or written goes on to its next check
  sigaction(signal, &action, nullptr);
}

}  // namespace

void handle_signals(StopToken& stop) {
  token.store(&stop);
  install(SIGINT, on_signal);
  install(SIGTERM, on_signal);
  install(SIGPIPE, SIG_IGN);
  install(SIGXFSZ, SIG_IGN);  // a file beyond the limit of its size fails as on a full disk
}

void end_at_once_on_signals() { token.store(nullptr); }

EndAtOnceOnSignals::EndAtOnceOnSignals() : stop_(token.exchange(nullptr)) {
  // Nobody would look at a request that came before.
  if (stop_ != nullptr && stop_->requested()) _exit(static_cast<int>(ExitStatus::kInterrupted));
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
  if (stop.requested()) throw Error(ExitStatus::kInterrupted, "interrupted; nothing was written");
}

}  // namespace orbweave
