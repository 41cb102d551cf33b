#include "io/text/text_fields.h"

#include <algorithm>

#include "io/text/text_number.h"

namespace orbweave {
namespace {

constexpr std::string_view kBlanks = " \t\r";

/// The length of a field in quotes at the front of the text, with the blanks around it; separators
/// may be inside, and quotes that are doubled. Nothing where no such field ends before a separator.
std::optional<std::size_t> quoted_length(std::string_view text, char separator) {
  const std::string_view blanks = separator == '\t' ? " \r" : kBlanks;
  const std::size_t open = text.find_first_not_of(blanks);
  if (open == text.npos || text[open] != '"') return std::nullopt;
  std::size_t close = text.find('"', open + 1);
  while (close != text.npos && close + 1 < text.size() && text[close + 1] == '"')
    close = text.find('"', close + 2);
  if (close == text.npos) return std::nullopt;
  const std::size_t behind = std::min(text.find_first_not_of(blanks, close + 1), text.size());
  const bool ends =
      behind == text.size() || (separator == ' ' ? behind != close + 1 : text[behind] == separator);
  return ends ? std::optional(behind) : std::nullopt;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::optional<std::string_view> take_field(std::string_view& line, char separator) {
  std::string_view field;
  if (separator == ' ') {
    line = trimmed(line);
    if (line.empty()) return std::nullopt;
    const std::size_t end =
        quoted_length(line, separator).value_or(std::min(line.find_first_of(kBlanks), line.size()));
    field = trimmed(line.substr(0, end));
    line.remove_prefix(end);
  } else {
    if (trimmed(line).empty()) return std::nullopt;
    const std::size_t end =
        quoted_length(line, separator).value_or(std::min(line.find(separator), line.size()));
    field = trimmed(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
    field = trimmed(field.substr(1, field.size() - 2));
  return field;
}

std::vector<std::string_view> fields_of(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  while (const auto field = take_field(line, separator)) fields.push_back(*field);
  return fields;
}

char find_separator(std::string_view line) {
  for (const char c : {';', ','})
    if (line.find(c) != line.npos) return c;
  // Tabs count as blanks, unless they set off names that have blanks inside.
  const auto tabbed = fields_of(line, '\t');
  const bool blank_inside = std::any_of(tabbed.begin(), tabbed.end(), [](std::string_view field) {
    return field.find(' ') != field.npos;
  });
  return tabbed.size() >= 3 && blank_inside ? '\t' : ' ';
}

bool to_number(std::string_view field, double& value) {
  const char* const last = field.data() + field.size();
  return !field.empty() && parse_number(field.data(), last, value) == last;
}

}  // namespace orbweave
