#include "io/job/job_defaults.h"

#include <algorithm>
#include <string_view>

#include "io/job/job_keys.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

constexpr std::size_t kColumns = 100;

/// A comment of as many lines as the text needs.
std::string comment(std::string_view text) {
  std::string lines, line = "#";
  for (const std::string_view word : words_of(text)) {
    if (line.size() > 1 && line.size() + 1 + word.size() > kColumns) {
      lines += line + "\n";
      line = "#";
    }
    line += " " + std::string(word);
  }
  return lines + line + "\n";
}

std::string sentence(std::string text) {
  if (!text.empty() && text.front() >= 'a' && text.front() <= 'z')
    text.front() = static_cast<char>(text.front() - 'a' + 'A');
  return text + ".";
}

std::string option_text(const JobKey& key) {
  if (*key.option == '\0') return "";
  return comment("Option: --" + std::string(key.option));
}

std::string key_text(const JobKey& key) {
  return "\n" + comment(sentence(key.help)) + comment("Accepted: " + key.expected()) +
         option_text(key) + key.key + " = " + key.default_text() + "\n";
}

}  // namespace

std::string commented_job_file() {
  std::string text =
      comment(
          "A job of orbweave with every key at its default. Only input.files and output.mesh have "
          "to be set; a key that is left out has its default. Paths are relative to this file.") +
      comment("Run: orbweave run JOB.toml");
  std::string_view section;
  for (const JobKey& key : job_keys()) {
    if (section != key.section) text += "\n[" + std::string(key.section) + "]\n";
    section = key.section;
    text += key_text(key);
  }
  return text;
}

}  // namespace orbweave
