#include "python/src/others_may_run.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>
#include <vector>

namespace py = pybind11;

namespace orbweave::python {
namespace {

/// What the module does beside the interpreter. Read and changed with the interpreter's lock alone.
struct Beside {
  std::vector<WorkBeside*> works;
  int threads_without_lock = 0;
  std::optional<std::thread::id> last_thread;  ///< that ends the interpreter, once it does

  bool is_quiet() const {
    return threads_without_lock == 0 &&
           std::ranges::all_of(works, [](const WorkBeside* work) { return work->has_ended(); });
  }
};

Beside& beside() {
  static Beside one;
  return one;
}

/// Threads that still run when the interpreter is taken down end the process with SIGABRT: they
/// cannot come back through C++ without the lock, and what they use is destroyed.
void end_work() {
  beside().last_thread = std::this_thread::get_id();
  for (WorkBeside* work : beside().works) work->stop();
  while (!beside().is_quiet()) {
    const py::gil_scoped_release others_may_run;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

OthersMayRun::OthersMayRun() {
  if (beside().last_thread) return;
  ++beside().threads_without_lock;
  thread_ = PyEval_SaveThread();
}

OthersMayRun::~OthersMayRun() {
  if (thread_ == nullptr) return;
  PyEval_RestoreThread(thread_);
  --beside().threads_without_lock;
}

WorkBeside::WorkBeside(StopToken& stop) : stop_(stop) {
  beside().works.push_back(this);
  if (is_to_end()) stop_.request();
}

WorkBeside::~WorkBeside() { std::erase(beside().works, this); }

bool is_to_end() {
  return beside().last_thread && *beside().last_thread != std::this_thread::get_id();
}

void wait_for_work_at_exit() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&end_work));
  // Of all threads a child has the one that forked.
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function([] { beside() = {}; }));
}

}  // namespace orbweave::python
