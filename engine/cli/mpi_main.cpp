// The program of a team: the same as main.cpp by every process that mpirun starts, but for the
// end, which is a common one.
#include "engine/cli/command_line.h"
#include "engine/cli/exit_status.h"
#include "engine/cli/failure.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/system/hdf5_exit.h"
#include "io/system/standard_streams.h"
#include "partition/mpi_communicator.h"

namespace {

orbweave::StopToken stop;
ORBWEAVE_END_PLAINLY_FROM_THE_START;

void work(const std::vector<std::string>& arguments, orbweave::MpiCommunicator& communicator) {
  // mpirun kills what has not ended a second after the signal, and chunks may take longer.
  const orbweave::StopNotice notice(stop, [leads = communicator.is_root()] {
    if (leads) orbweave::print_warning("stopping; what is done is kept, the same command resumes");
  });
  orbweave::parse_team_command_line(arguments, stop, communicator)();
  orbweave::flush_output();
  communicator.leave(stop);
}

void run(const std::vector<std::string>& arguments, orbweave::MpiCommunicator& communicator) {
  try {
    orbweave::handle_signals(stop);
    work(arguments, communicator);
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    // mpirun ends the others by a signal: what there is to say is said here.
    orbweave::set_last_word("");
    communicator.fail(static_cast<int>(orbweave::exit_status(failure.kind)),
                      failure.kind == orbweave::ErrorKind::kInterrupted, failure.what,
                      orbweave::print_error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  orbweave::hold_closed_streams();
  orbweave::close_hdf5_at_exit();
  try {
    orbweave::MpiCommunicator communicator;
    run({argv, argv + argc}, communicator);
    return static_cast<int>(orbweave::ExitStatus::kDone);
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    orbweave::print_error(failure.what);
    return static_cast<int>(orbweave::exit_status(failure.kind));
  }
}
