// Numbers on the command line, independent of the locale.
#pragma once

#include <cstdint>
#include <string>

namespace orbweave {

/// A finite number, or Error (usage) that names the option and what was found.
double number_argument(const std::string& option, const std::string& text);
/// A finite number above 0.
double positive_argument(const std::string& option, const std::string& text);
/// A whole number from 0 to 2^53; "2e6" is one, too.
std::uint64_t count_argument(const std::string& option, const std::string& text);

}  // namespace orbweave
