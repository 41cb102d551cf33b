#include "io/job/job_file.h"

#include <algorithm>
#include <cerrno>
#include <map>
#include <optional>
#include <utility>

#include "io/error.h"
#include "io/job/toml_document.h"
#include "io/system/file_descriptor.h"
#include "io/system/small_file.h"
#include "io/system/system_advice.h"
#include "io/text/nearest_name.h"
#include "io/text/text_fields.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

const JobKey* find_key(std::string_view written_section, std::string_view key) {
  const std::string_view section = current_section(written_section);
  for (const JobKey& known : job_keys())
    if (section == known.section && key == known.key) return &known;
  return nullptr;
}

std::vector<std::string> section_names() {
  std::vector<std::string> names;
  for (const JobKey& known : job_keys())
    if (names.empty() || names.back() != known.section) names.emplace_back(known.section);
  return names;
}

/// A key in the wrong section is likelier than a word that is misspelt altogether. Empty where no
/// key is like it.
std::string nearest_key(const std::string& section, const std::string& key) {
  const JobKey* nearest = nullptr;
  std::size_t smallest = 0;
  for (const JobKey& known : job_keys()) {
    if (!may_mean(key, known.key)) continue;
    const std::size_t distance =
        2 * edit_distance(key, known.key) + (current_section(section) == known.section ? 0 : 1);
    if (nearest != nullptr && distance >= smallest) continue;
    nearest = &known;
    smallest = distance;
  }
  return nearest != nullptr ? nearest->name() : "";
}

std::string advice_on_section(const std::string& section) {
  const std::string nearest = nearest_name(section, section_names());
  return nearest.empty() ? "The sections are " + joined(section_names()) + "."
                         : "Did you mean [" + nearest + "]?";
}

/// What to do about a key that is like none.
std::string advice_on_keys(const std::string& section) {
  std::vector<std::string> keys;
  for (const JobKey& known : job_keys())
    if (current_section(section) == known.section) keys.emplace_back(known.key);
  return keys.empty() ? advice_on_section(section)
                      : "The keys of [" + section + "] are " + joined(keys) + ".";
}

[[noreturn]] void throw_unknown_section(const std::string& section, ErrorParts where) {
  where.advice = advice_on_section(section);
  throw_usage("unknown section [" + section + "]", where);
}

[[noreturn]] void throw_unknown_key(const std::string& section, const std::string& key,
                                    ErrorParts where) {
  const std::string nearest = nearest_key(section, key);
  where.advice = nearest.empty() ? advice_on_keys(section) : "Did you mean " + nearest + "?";
  throw_usage("unknown key " + (section.empty() ? "" : section + ".") + key, where);
}

bool is_section(std::string_view name) {
  const std::vector<std::string> known = section_names();
  return std::ranges::find(known, current_section(name)) != known.end();
}

/// A section that has a value, or comes several times as [[section]].
[[noreturn]] void throw_section_as_key(const std::string& section, const std::string& found,
                                       ErrorParts where) {
  where.found = found;
  where.expected = where.file.empty() ? "a key of it: " + section + ".KEY=VALUE"
                                      : "[" + section + "] once, and its keys below";
  throw_usage("unknown key " + section + ": this is the name of a section", where);
}

/// fill.max_edges below [output] is a key of [output], by the rules of TOML.
[[noreturn]] void throw_section_in_section(const TomlEntry& entry, ErrorParts where) {
  where.expected = entry.key == entry.section
                       ? "the key without the name of its section"
                       : "[" + entry.key + "] on a line of its own, and its keys below";
  throw_usage("unknown key " + entry.section + "." + entry.key + ": " + entry.key +
                  " is a section, and what stands below [" + entry.section + "] belongs to that",
              where);
}

/// `called`: the key as the user gave it.
void apply(Job& job, const JobKey& key, const std::string& called, const WrittenValue& value,
           ErrorParts where) {
  try {
    key.set(job, value);
  } catch (const UnsuitableValue& unsuitable) {
    where.found = value.text;
    where.expected = unsuitable.expected.empty() ? key.expected() : unsuitable.expected;
    throw_usage(called + (unsuitable.problem.empty() ? " has an unsuitable value"
                                                     : ": " + unsuitable.problem),
                where);
  }
}

/// A section's own line, which may say [a.b] or [[a]], or be no section at all.
void check_section(const TomlEntry& entry, const ErrorParts& where) {
  if (!is_section(entry.section)) throw_unknown_section(entry.section, where);
}

void apply(Job& job, const TomlEntry& entry, const std::string& name,
           const std::filesystem::path& base_directory) {
  const ErrorParts where{.file = name, .place = "line " + std::to_string(entry.line)};
  if (entry.key.empty()) return check_section(entry, where);
  if (entry.section.empty() && is_section(entry.key))
    throw_section_as_key(entry.key, entry.value.text, where);
  if (entry.section.empty() && entry.is_list_of_tables) throw_unknown_section(entry.key, where);
  const JobKey* key = find_key(entry.section, entry.key);
  if (key == nullptr && is_section(entry.section) && is_section(entry.key))
    throw_section_in_section(entry, where);
  if (key == nullptr) throw_unknown_key(entry.section, entry.key, where);
  WrittenValue value = entry.value;
  value.base_directory = base_directory;
  apply(job, *key, key->name(), value, where);
}

/// A section under two names says twice what is to hold once.
void check_names_of_sections(const std::vector<TomlEntry>& entries, const std::string& name) {
  const auto place = [](const TomlEntry& entry) {
    return "[" + entry.section + "] in line " + std::to_string(entry.line);
  };
  std::map<std::string_view, const TomlEntry*> first;
  for (const TomlEntry& entry : entries) {
    const std::string_view section = current_section(entry.section);
    const TomlEntry& before = *first.try_emplace(section, &entry).first->second;
    if (before.section == entry.section) continue;
    throw_usage("one section under two names",
                {.file = name,
                 .place = "line " + std::to_string(entry.line),
                 .found = place(before) + " and " + place(entry),
                 .expected = "[" + std::string(section) + "] alone"});
  }
}

std::string file_text(const std::filesystem::path& path) {
  std::optional<std::string> text = small_file_text(path, kTomlLimitBytes + 1);
  if (text) return std::move(*text);
  if (is_failure(errno)) throw_unread("cannot read the job file", {.file = path.string()}, errno);
  throw_usage("cannot open the job file: " + system_reason(errno), {.file = path.string()});
}

/// Keys whose values are words rather than TOML, where they come from a command line.
bool takes_words(JobKeyType type) {
  return type == JobKeyType::kPath || type == JobKeyType::kDirectory ||
         type == JobKeyType::kPaths || type == JobKeyType::kTexts || type == JobKeyType::kChoice ||
         type == JobKeyType::kColor || type == JobKeyType::kSimplification;
}

bool is_list(JobKeyType type) {
  return type == JobKeyType::kPaths || type == JobKeyType::kTexts || type == JobKeyType::kNumbers;
}

/// The text as one TOML value; nothing where it is none.
std::optional<WrittenValue> toml_value(const std::string& text) {
  if (text.find_first_of("\r\n") != std::string::npos) return std::nullopt;
  try {
    const std::vector<TomlEntry> entries = read_toml("value = " + text, "value");
    if (entries.size() == 1 && entries[0].section.empty()) return entries[0].value;
  } catch (const Error&) {
    // A bare word then.
  }
  return std::nullopt;
}

WrittenValue bare_words(const std::string& text, JobKeyType type) {
  WrittenValue value{.text = "\"" + text + "\""};
  if (!is_list(type) || text.find(',') == std::string::npos) {
    value.items.emplace_back(text);
    return value;
  }
  value.shape = WrittenValue::Shape::kList;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    value.items.emplace_back(text.substr(begin, comma - begin));
    begin = comma + 1;
  }
  return value;
}

/// ".5" and "5." as TOML wants them: "0.5" and "5.0". Other text as it is.
std::string with_zeros(const std::string& text) {
  if (text.find_first_not_of("0123456789.,eE+-") != std::string::npos) return text;
  const auto is_digit = [&](std::size_t at) {
    return at < text.size() && text[at] >= '0' && text[at] <= '9';
  };
  std::string whole;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool before = i > 0 && is_digit(i - 1), after = is_digit(i + 1);
    if (text[i] == '.' && after && !before) whole += '0';
    whole += text[i];
    if (text[i] == '.' && before && !after) whole += '0';
  }
  return whole;
}

WrittenValue command_line_value(const std::string& text, JobKeyType type) {
  const bool quoted = text.starts_with('"') || text.starts_with('\'');
  if (takes_words(type) && !quoted && !(is_list(type) && text.starts_with('[')))
    return bare_words(text, type);
  if (type == JobKeyType::kNumbers && text.find(',') != std::string::npos)
    if (auto list = toml_value("[" + with_zeros(text) + "]"); list && !text.starts_with('['))
      return *list;
  const std::optional<WrittenValue> value = toml_value(with_zeros(text));
  return value ? *value : bare_words(text, type);
}

/// Whether the values of the key are numbers with a range.
bool has_range(const JobKey& key) {
  if (key.name() == "input.crop") return false;
  return key.type == JobKeyType::kInteger || key.type == JobKeyType::kBytes ||
         key.type == JobKeyType::kNumber || key.type == JobKeyType::kNumbers ||
         key.type == JobKeyType::kSimplification;
}

/// The items of a value, as a job file would have them.
struct ItemsOf {
  template <class T>
  WrittenValue operator()(const std::vector<T>& list) const {
    return {.shape = WrittenValue::Shape::kList, .items = {list.begin(), list.end()}};
  }
  template <class T>
  WrittenValue operator()(const T& item) const {
    return {.items = {item}};
  }
};

}  // namespace

Job parse_job(std::string_view text, const std::string& name,
              const std::filesystem::path& base_directory) {
  Job job;
  const std::vector<TomlEntry> entries = read_toml(text, name);
  check_names_of_sections(entries, name);
  for (const TomlEntry& entry : entries) apply(job, entry, name, base_directory);
  return job;
}

Job read_job_file(const std::filesystem::path& path) {
  return parse_job(file_text(path), path.string(), path.parent_path());
}

void set_job_option(Job& job, std::string_view name, std::string_view text) {
  for (const JobKey& key : job_keys())
    if (key.name() == name)
      apply(job, key, std::string("--") + key.option,
            command_line_value(std::string(text), key.type), {});
}

void set_job_key(Job& job, std::string_view name, std::string_view text) {
  const std::size_t dot = std::min(name.find('.'), name.size());
  const bool has_section = dot < name.size();
  const std::string section(has_section ? name.substr(0, dot) : "");
  const std::string key(has_section ? name.substr(dot + 1) : name);
  if (!has_section && is_section(key)) throw_section_as_key(key, std::string(text), {});
  const JobKey* known = find_key(section, key);
  if (known == nullptr) throw_unknown_key(section, key, {});
  apply(job, *known, known->name(), command_line_value(std::string(text), known->type), {});
}

void set_job_key(Job& job, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos)
    throw_usage("no value given for a key",
                {.found = "\"" + std::string(assignment) + "\"", .expected = "section.key=value"});
  const std::string_view name = assignment.substr(0, equals);
  const std::string_view value = assignment.substr(equals + 1);
  // "key = value" is a line of a job file; in "key= value" the blank may belong to a name.
  if (name.ends_with(' ')) return set_job_key(job, trimmed(name), trimmed(value));
  set_job_key(job, name, value);
}

void check_job_numbers(const Job& job) {
  Job checked;
  for (const JobKey& key : job_keys()) {
    if (!has_range(key)) continue;
    const JobValue value = key.get(job);
    WrittenValue written = std::visit(ItemsOf{}, value);
    written.text = value_text(value, key.type);
    apply(checked, key, key.name(), written, {});
  }
}

std::string job_toml(const Job& job) {
  std::string text;
  const char* section = "";
  for (const JobKey& key : job_keys()) {
    if (std::string_view(section) != key.section)
      text += (text.empty() ? "[" : "\n[") + std::string(key.section) + "]\n";
    section = key.section;
    text += std::string(key.key) + " = " + value_text(key.get(job), key.type) + "\n";
  }
  return text;
}

}  // namespace orbweave
