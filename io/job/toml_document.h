// A TOML document as a flat list of what it says. The one place that knows the TOML library.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "io/job/job_keys.h"

namespace orbweave {

/// One key with its value; with an empty `section` for a key outside of every section, with an
/// empty `key` for a section's own line.
struct TomlEntry {
  std::string section;
  std::string key;
  WrittenValue value;
  std::size_t line = 0;
  bool is_list_of_tables = false;  ///< [[key]]
};

/// Longest document, and deepest nesting, that is read. The parser takes quadratic time: about a
/// second for the longest.
inline constexpr std::size_t kTomlLimitBytes = std::size_t{1} << 16;
inline constexpr int kTomlLimitDepth = 32;

/// The document's entries in the order of its lines. Throws Error (usage) with `name` and line
/// for what is no TOML, exceeds the limits, or does not decode.
std::vector<TomlEntry> read_toml(std::string_view text, const std::string& name);

}  // namespace orbweave
