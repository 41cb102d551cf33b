// Manual pages (man) of the program and of its commands.
#pragma once

#include <string>
#include <vector>

#include "engine/cli/command_table.h"

namespace orbweave {

/// "orbweave", "orbweave-run", ..., "orbweave-mpi": a page for the program, one for each command,
/// and that of the program for several processes.
std::vector<std::string> manual_page_names(const ProgramFacts& program);

/// The page of that name, for man(1). Throws Error (usage) for a name that is none of them.
std::string manual_page(const ProgramFacts& program, const std::string& name);

}  // namespace orbweave
