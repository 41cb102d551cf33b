// The nearest known name to a misspelt one.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace orbweave {

/// Insertions, deletions, replacements and swaps of neighbours that turn a into b (Damerau and
/// Levenshtein's distance, each piece of text edited once). O(|a| |b|).
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known name at the smallest edit distance, the first of several; "" where none is known.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);

}  // namespace orbweave
