#include "io/job/job_reference.h"

#include <string_view>

#include "io/job/job_keys.h"

namespace orbweave {
namespace {

/// What Markdown would take for markup in running text.
std::string plain(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("\\`*_{}[]<>#|").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string capitalised(std::string text) {
  if (!text.empty() && text.front() >= 'a' && text.front() <= 'z')
    text.front() = static_cast<char>(text.front() - 'a' + 'A');
  return text;
}

/// "`--no-fill` (sets `false`)"
std::string option_text(const JobKey& key) {
  if (*key.option == '\0') return "none; `--set " + key.name() + "=VALUE`";
  std::string option = "`--" + std::string(key.option) + "`";
  if (*key.option_value == '\0') return option;
  return option + ", which sets `" + key.option_value + "`";
}

std::string key_text(const JobKey& key) {
  return "### `" + key.name() + "`\n\n" + capitalised(plain(key.help)) + ".\n\n" +
         "- Type: " + type_name(key.type) + "\n" + "- Accepted: " + plain(key.expected()) + "\n" +
         "- Default: `" + key.default_text() + "`\n" + "- Option: " + option_text(key) + "\n\n";
}

}  // namespace

std::string job_key_reference() {
  std::string text;
  std::string_view section;
  for (const JobKey& key : job_keys()) {
    if (section != key.section) text += "## \\[" + std::string(key.section) + "\\]\n\n";
    section = key.section;
    text += key_text(key);
  }
  return text;
}

}  // namespace orbweave
