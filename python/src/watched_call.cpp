#include "python/src/watched_call.h"

#include <cxxabi.h>

#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "python/src/errors.h"
#include "python/src/others_may_run.h"
#include "python/src/texts.h"

namespace py = pybind11;

namespace orbweave::python {
namespace {

/// How long Ctrl-C may go unseen.
constexpr std::chrono::milliseconds kBetweenLooks{50};

/// Leaves a thread that outlives the main one, without a word.
[[noreturn]] void end_thread() {
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

}  // namespace

void WatchedCall::run(const std::function<void()>& work) {
  std::exception_ptr failure, objection;
  WorkBeside beside(stop_);
  std::jthread worker([&] {
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
    }
    {
      const std::scoped_lock lock(mutex_);
      has_ended_ = true;
      changed_.notify_one();
    }
    beside.end();
  });
  bool goes_on = true;
  while (goes_on) {
    std::deque<News> news;
    goes_on = wait(news);
    if (objection != nullptr) continue;
    try {
      pass_on(news);
    } catch (const abi::__forced_unwind&) {
      throw;  // the interpreter is gone, and ends its threads
    } catch (...) {
      objection = std::current_exception();
      stop_.request();
    }
  }
  {
    const OthersMayRun others_may_run;
    worker.join();
  }
  if (is_to_end()) end_thread();
  if (objection != nullptr) std::rethrow_exception(objection);
  if (failure != nullptr) std::rethrow_exception(failure);
}

bool WatchedCall::wait(std::deque<News>& news) {
  const OthersMayRun others_may_run;
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, kBetweenLooks, [&] { return has_ended_ || !news_.empty(); });
  news.swap(news_);
  return !has_ended_;
}

void WatchedCall::pass_on(const std::deque<News>& news) {
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
  for (const News& one : news) {
    if (one.is_warning)
      warn_of(one.text);
    else if (!progress_.is_none())
      progress_(text_of(one.text), one.done);
  }
}

void WatchedCall::tell(std::string stage, double done) {
  add({.text = std::move(stage), .done = done});
}

void WatchedCall::warn(std::string line) { add({.text = std::move(line), .is_warning = true}); }

void WatchedCall::add(News news) {
  const std::scoped_lock lock(mutex_);
  news_.push_back(std::move(news));
  changed_.notify_one();
}

}  // namespace orbweave::python
