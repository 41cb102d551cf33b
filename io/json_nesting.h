// JSON from outside whose lists and objects lie within each other too deeply.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace orbweave {

/// Copies, comparisons and texts of a document call themselves for each level; the stack of a
/// thread has room for some ten thousand calls.
inline constexpr std::size_t kMostJsonLevels = 256;

/// Whether the text, if it is JSON, has more levels. O(n).
bool nests_too_deeply(std::string_view text);

/// "at most 256 levels".
std::string expected_json_levels();

/// The document of a text; a discarded one where the text is no JSON, or has more levels.
nlohmann::json json_of(std::string_view text);

}  // namespace orbweave
