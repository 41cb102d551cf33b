#include "io/job/toml_document.h"

#include <algorithm>
#include <charconv>
#include <sstream>
#include <toml.hpp>

#include "io/error.h"

namespace orbweave {
namespace {

constexpr std::size_t kShownLength = 60;

std::string at_line(std::size_t line) { return "line " + std::to_string(line); }

std::string shortened(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  if (text.size() <= kShownLength) return text;
  return text.substr(0, kShownLength) + "...";
}

/// Bytes of the UTF-8 character at the front of the text, which is not empty; 0 where that is none
/// (overlong forms and surrogates included) or where TOML has no such control character.
std::size_t character_bytes(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(0);
  if (first < 0x20) return first == '\t' || first == '\n' || first == '\r' ? 1 : 0;
  if (first < 0x80) return first == 0x7f ? 0 : 1;
  const std::size_t count = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (count == 0 || first > 0xf4) return 0;
  for (std::size_t i = 1; i < count; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  const bool is_overlong = (first == 0xe0 && byte(1) < 0xa0) || (first == 0xf0 && byte(1) < 0x90);
  const bool is_no_character =
      (first == 0xed && byte(1) >= 0xa0) || (first == 0xf4 && byte(1) >= 0x90);
  return is_overlong || is_no_character ? 0 : count;
}

/// toml11 reads outside of the text when it reports such bytes in a string.
void check_characters(std::string_view text, const std::string& name) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
    throw_usage("the job file is UTF-16",
                {.file = name,
                 .expected = "UTF-8",
                 .advice = "PowerShell 5 writes it so with: Out-File -Encoding utf8"});
  std::size_t line = 1;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t bytes = character_bytes(text.substr(at, 4));
    if (bytes == 0)
      throw_usage("not valid TOML: a byte that is no UTF-8 text",
                  {.file = name,
                   .place = at_line(line),
                   .found = "byte " + std::to_string(static_cast<unsigned char>(text[at])),
                   .advice = "Name files whose names are no UTF-8 by a pattern, or on the command "
                             "line"});
    if (text[at] == '\n') ++line;
    at += bytes;
  }
}

/// The parser recurses per bracket and per dot of a key, so both are counted before it runs.
/// Strings are skipped as TOML defines them; where the text is no TOML the parser stops anyway.
class NestingCheck {
 public:
  NestingCheck(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  void run() {
    while (at_ < text_.size()) step();
  }

 private:
  void step() {
    const char c = text_[at_];
    if (c == '"' || c == '\'') {
      skip_string(c);
      return;
    }
    if (c == '#') at_ = std::min(text_.find('\n', at_), text_.size() - 1);
    if (text_[at_] == '\n') ++line_;
    if (c == '[' || c == '{') ++brackets_;
    if (c == ']' || c == '}') brackets_ = std::max(0, brackets_ - 1);
    if (c == '.') ++dots_;
    if (std::string_view(",=[]{}\n#").find(c) != std::string_view::npos) dots_ = 0;
    if (brackets_ + dots_ > kTomlLimitDepth)
      throw_usage("nested too deeply",
                  {.file = name_,
                   .place = at_line(line_),
                   .expected = "at most " + std::to_string(kTomlLimitDepth) + " levels"});
    ++at_;
  }

  void skip_string(char quote) {
    const std::string triple(3, quote);
    const bool long_string = text_.substr(at_, 3) == triple;
    for (at_ += long_string ? 3 : 1; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\n' && !long_string) return;
      if (text_[at_] == '\n') ++line_;
      if (text_[at_] == '\\' && quote == '"') {
        ++at_;
      } else if (long_string ? text_.substr(at_, 3) == triple : text_[at_] == quote) {
        at_ += long_string ? 3 : 1;
        return;
      }
    }
  }

  std::string_view text_;
  const std::string& name_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  int brackets_ = 0;
  int dots_ = 0;
};

/// The value as it stands in the document, as far as it is on one line.
std::string written_text(const toml::value& value) {
  const toml::source_location where = value.location();
  const std::string& line = where.line_str();
  const std::size_t begin = where.column() == 0 ? 0 : where.column() - 1;
  if (begin >= line.size()) return "";
  return line.substr(begin, where.region());
}

template <class Number>
bool parse_whole(const std::string& text, Number& number) {
  const char* const last = text.data() + text.size();
  const auto result = std::from_chars(text.data(), last, number);
  return result.ptr == last && !text.empty() && result.ec == std::errc();
}

/// toml11 reads numbers through streams, hence by the locale, and silently clamps those that are
/// too large; so numbers are read from their text, without what std::from_chars does not know:
/// underscores and a leading '+'.
std::string number_text(const toml::value& value) {
  std::string digits;
  for (const char c : written_text(value))
    if (c != '_') digits += c;
  return digits.starts_with('+') ? digits.substr(1) : digits;
}

bool read_scalar(const toml::value& value, WrittenValue::Scalar& out) {
  if (value.is_boolean()) {
    out = value.as_boolean();
  } else if (value.is_string()) {
    out = value.as_string().str;
  } else if (value.is_integer()) {
    std::int64_t integer = 0;
    const std::string text = number_text(value);
    const bool decimal = text.find_first_of("xob") == std::string::npos;
    if (decimal && !parse_whole(text, integer)) return false;
    out = decimal ? integer : value.as_integer();
  } else if (value.is_floating()) {
    double number = 0.0;
    if (!parse_whole(number_text(value), number)) return false;
    out = number;
  } else {
    return false;
  }
  return true;
}

bool is_list_of_tables(const toml::value& value) {
  return value.is_array() && !value.as_array().empty() &&
         std::ranges::all_of(value.as_array(), [](const auto& item) { return item.is_table(); });
}

WrittenValue written_value(const toml::value& value) {
  WrittenValue written;
  written.text = shortened(written_text(value));
  if (value.is_table()) written.text = "a table";
  if (is_list_of_tables(value)) written.text = "a list of tables";
  WrittenValue::Scalar item;
  if (value.is_table() && value.as_table().size() == 1) {
    const auto& [name, only] = *value.as_table().begin();
    if (read_scalar(only, item)) written.items = {name, item};
  }
  if (value.is_array()) {
    written.shape = WrittenValue::Shape::kList;
    for (const toml::value& element : value.as_array()) {
      if (!read_scalar(element, item)) written.shape = WrittenValue::Shape::kOther;
      written.items.push_back(item);
    }
  } else if (read_scalar(value, item)) {
    written.items.push_back(item);
  } else {
    written.shape = WrittenValue::Shape::kOther;
  }
  return written;
}

std::size_t line_of(const toml::value& value) { return value.location().line(); }

void add_section(const std::string& name, const toml::value& section,
                 std::vector<TomlEntry>& entries) {
  entries.push_back({name, "", {}, line_of(section)});
  for (const auto& [key, value] : section.as_table())
    entries.push_back({name, key, written_value(value), line_of(value)});
}

std::vector<TomlEntry> entries_of(const toml::value& document) {
  std::vector<TomlEntry> entries;
  for (const auto& [name, value] : document.as_table()) {
    if (value.is_table())
      add_section(name, value, entries);
    else
      entries.push_back({"", name, written_value(value), line_of(value), is_list_of_tables(value)});
  }
  // The library's tables have no order, and the first mistake is to be reported first.
  std::ranges::sort(entries, [](const TomlEntry& a, const TomlEntry& b) {
    return std::tie(a.line, a.section, a.key) < std::tie(b.line, b.section, b.key);
  });
  return entries;
}

/// "[error] toml::parse_table: invalid line format\n --> ..." becomes "invalid line format".
std::string problem_of(const std::string& message) {
  std::string problem = message.substr(0, message.find('\n'));
  if (problem.starts_with("[error] ")) problem = problem.substr(8);
  if (const std::size_t colon = problem.find(": ");
      problem.starts_with("toml::") && colon != std::string::npos)
    problem = problem.substr(colon + 2);
  while (problem.ends_with('.')) problem.pop_back();
  return shortened(problem);
}

/// What would be right, as far as the problem and its line tell; empty: they do not.
std::string expected_instead(const std::string& problem, const std::string& line) {
  const auto speaks_of = [&](std::string_view words) {
    return problem.find(words) != std::string::npos;
  };
  if (line.find('"') < line.find('\\') && line.find('\\') != std::string::npos)
    return "backslashes in single quotes: '...'; in double quotes each of them is written twice";
  if (speaks_of("unknown value") || speaks_of("value having invalid format") ||
      speaks_of("invalid line format"))
    return "a text in quotes, a number such as 0.05, true, false, or a list of these in [ ]";
  if (speaks_of("invalid key")) return "key = value, [section], or a comment behind #";
  return {};
}

[[noreturn]] void throw_syntax(const std::string& name, const toml::exception& error) {
  const std::string problem = problem_of(error.what());
  throw_usage("not valid TOML: " + problem,
              {.file = name,
               .place = at_line(error.location().line()),
               .found = "'" + shortened(error.location().line_str()) + "'",
               .expected = expected_instead(problem, error.location().line_str())});
}

toml::value parse(std::string_view text, const std::string& name) {
  std::istringstream stream{std::string(text)};
  try {
    return toml::parse(stream, name);
  } catch (const toml::exception& error) {
    throw_syntax(name, error);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw_usage("not valid TOML: " + problem_of(error.what()), {.file = name});
  }
}

}  // namespace

std::vector<TomlEntry> read_toml(std::string_view text, const std::string& name) {
  if (text.size() > kTomlLimitBytes)
    throw_usage("too long for a job file",
                {.file = name,
                 .found = std::to_string(text.size()) + " bytes",
                 .expected = "at most " + std::to_string(kTomlLimitBytes) + " bytes",
                 .advice = "Name the scans by a pattern such as \"scans/*.ply\"."});
  check_characters(text, name);
  NestingCheck(text, name).run();
  return entries_of(parse(text, name));
}

}  // namespace orbweave
