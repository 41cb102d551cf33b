// Words of a line, separated by blanks, and the numbers that they are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace orbweave {

std::vector<std::string_view> words_of(std::string_view line);

std::string joined(const std::vector<std::string>& words);  ///< "a, b, c"

/// The number that a word is as a whole, independent of the locale. Throws std::invalid_argument
/// where it is none or not finite.
double finite_number(std::string_view word);

}  // namespace orbweave
