// Lines of text as fields.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace orbweave {

/// The text without blanks at its ends.
std::string_view trimmed(std::string_view text);

/// Removes the next field, and the separator behind it, from a line; blanks around the field and
/// quotes are taken off. What is in quotes may hold separators. Nothing at the line's end.
std::optional<std::string_view> take_field(std::string_view& line, char separator);

/// All fields of a line.
std::vector<std::string_view> fields_of(std::string_view line, char separator);

/// The separator of a line of names or numbers: semicolon, comma, tab where tabs set off names that
/// have blanks inside, or else a blank, which stands for any run of blanks and tabs.
char find_separator(std::string_view line);

/// Whether a whole field is a number, and which.
bool to_number(std::string_view field, double& value);

}  // namespace orbweave
