#include "io/text/text_fields.h"

#include <algorithm>

namespace orbweave {
namespace {

constexpr std::string_view kBlanks = " \t\r";

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
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    field = line.substr(0, end);
    line.remove_prefix(end);
  } else {
    if (trimmed(line).empty()) return std::nullopt;
    const std::size_t end = std::min(line.find(separator), line.size());
    field = trimmed(line.substr(0, end));
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"')
    field = trimmed(field.substr(1, field.size() - 2));
  return field;
}

}  // namespace orbweave
