// From the command line to the action that it asks for.
#pragma once

#include <string>
#include <vector>

#include "engine/cli/command_action.h"
#include "partition/executor.h"

namespace orbweave {

/// Parses `arguments` (the program's name first) and returns what is to be done; --help and
/// --version are actions too. `stop` must outlive the action. Throws Error (usage) with the
/// nearest known command or option where one is misspelt.
CommandAction parse_command_line(const std::vector<std::string>& arguments, const StopToken& stop);
/// The same for every member of a team, which knows only the commands that a team can share: run
/// and reconstruct. Members that do not lead print nothing. `team` must outlive the action.
CommandAction parse_team_command_line(const std::vector<std::string>& arguments,
                                      const StopToken& stop, Communicator& communicator);

}  // namespace orbweave
