// Lines of text as fields.
#pragma once

#include <optional>
#include <string_view>

namespace orbweave {

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text);

/// Removes the next field, and the separator behind it, from a line; blanks around the field and
/// quotes are taken off. What is in quotes may hold separators. Nothing at the line's end.
std::optional<std::string_view> take_field(std::string_view& line, char separator);

}  // namespace orbweave
