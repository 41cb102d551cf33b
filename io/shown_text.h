// Names that come from files (attributes, paths, coordinate systems) are bytes, and are kept as
// they are. Where they are shown, or become part of a text that has to be UTF-8, one rule holds: a
// byte that is not part of well-formed UTF-8 becomes \xNN, two hexadecimal digits.
#pragma once

#include <string>
#include <string_view>

namespace orbweave {

/// Whether the text is well-formed UTF-8 (Unicode 15, table 3-7).
bool is_utf8(std::string_view text);

/// For texts that programs read: well-formed UTF-8, other bytes as \xNN. All else as it is.
std::string as_utf8(std::string_view text);

/// For people: the same, and what a terminal would obey (control characters, among them the escape
/// sequences' first, and characters that turn the direction of writing) as \xNN, byte by byte. A
/// name shown thus stays on its line.
std::string shown(std::string_view text);

/// For documents that are read back: the same as as_utf8(), but a backslash becomes two, so that
/// unescaped_text(escaped_text(t)) == t for any bytes.
std::string escaped_text(std::string_view text);
std::string unescaped_text(std::string_view text);

}  // namespace orbweave
