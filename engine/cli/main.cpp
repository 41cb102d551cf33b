// The program: parses, builds, runs, and maps what went wrong to an exit status, here only.
#include "engine/cli/command_line.h"
#include "engine/cli/failure.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"

namespace {

orbweave::StopToken stop;

}  // namespace

int main(int argc, char** argv) {
  try {
    orbweave::handle_signals(stop);
    orbweave::parse_command_line({argv, argv + argc}, stop)();
    orbweave::flush_output();
    return static_cast<int>(orbweave::ExitStatus::kDone);
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    orbweave::print_error(failure.what);
    return static_cast<int>(failure.status);
  }
}
