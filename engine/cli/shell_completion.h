// Completion of command lines by shells.
#pragma once

#include <string>

#include "engine/cli/command_table.h"

namespace orbweave {

/// The script for "bash", "zsh" or "fish". Throws Error (usage) for another shell.
std::string shell_completion(const ProgramFacts& program, const std::string& shell);

}  // namespace orbweave
