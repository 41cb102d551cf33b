// The whole interface as one page for reading: keys, options, exit statuses.
#pragma once

#include <string>

#include "engine/cli/command_table.h"

namespace orbweave {

/// Markdown.
std::string reference_page(const ProgramFacts& program);

}  // namespace orbweave
