// The program of a team: the same as main.cpp by every process that mpirun starts, but for the
// end, which is a common one.
#include "engine/cli/command_line.h"
#include "engine/cli/failure.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "partition/mpi_team.h"

namespace {

orbweave::StopToken stop;

void work(const std::vector<std::string>& arguments, orbweave::MpiTeam& team) {
  // mpirun kills what has not ended a second after the signal, and chunks may take longer.
  const orbweave::StopNotice notice(stop, [leads = team.leads()] {
    if (leads) orbweave::print_warning("stopping; what is done is kept, the same command resumes");
  });
  orbweave::parse_team_command_line(arguments, stop, team)();
  orbweave::flush_output();
  team.leave(stop);
}

void run(const std::vector<std::string>& arguments, orbweave::MpiTeam& team) {
  try {
    orbweave::handle_signals(stop);
    work(arguments, team);
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    team.fail(failure.status, failure.what, orbweave::print_error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    orbweave::MpiTeam team;
    run({argv, argv + argc}, team);
    return static_cast<int>(orbweave::ExitStatus::kDone);
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    orbweave::print_error(failure.what);
    return static_cast<int>(failure.status);
  }
}
