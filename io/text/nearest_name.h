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

/// Whether a user who wrote the word may have meant the name: few letters differ, or the name
/// begins with the word.
bool may_mean(std::string_view word, std::string_view name);

/// The known name at the smallest edit distance that the word may mean, the first of several; ""
/// where there is none.
std::string nearest_name(std::string_view word, const std::vector<std::string>& known);
/// "Did you mean 'torus'?"; "" where there is none.
std::string advice_on_name(std::string_view word, const std::vector<std::string>& known);

}  // namespace orbweave
