// The program: parses, builds, runs, and maps what went wrong to an exit status, here only.
#include "engine/cli/command_line.h"
#include "engine/cli/exit_status.h"
#include "engine/cli/failure.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/system/hdf5_exit.h"
#include "io/system/standard_streams.h"

namespace {

orbweave::StopToken stop;
ORBWEAVE_END_PLAINLY_FROM_THE_START;

}  // namespace

int main(int argc, char** argv) {
  orbweave::hold_closed_streams();
  orbweave::close_hdf5_at_exit();
  try {
    orbweave::handle_signals(stop);
    orbweave::parse_command_line({argv, argv + argc}, stop)();
    orbweave::end_interruptible_work();
    orbweave::flush_output();
    return static_cast<int>(orbweave::ExitStatus::kDone);
  } catch (...) {
    orbweave::end_interruptible_work();
    const orbweave::Failure failure = orbweave::current_failure();
    orbweave::print_error(failure.what);
    return static_cast<int>(orbweave::exit_status(failure.kind));
  }
}
