#include "io/system/glob.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string_view>
#include <unordered_set>

#include "io/error.h"

namespace orbweave {
namespace {

bool is_there(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

bool is_directory(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

/// Coordinate systems, shifts and poses lie beside scans, and no reader takes them for one.
bool tells_of_scans(std::string_view path) {
  constexpr std::string_view kEnds[] = {".prj", ".shift.txt", ".conf", ".aln"};
  return std::ranges::any_of(kEnds, [&](std::string_view end) { return path.ends_with(end); });
}

/// GLOB_NOSORT, because glob's own order follows the locale.
std::vector<std::string> matches(const std::string& pattern) {
  glob_t found{};
  const std::unique_ptr<glob_t, void (*)(glob_t*)> freed(&found, globfree);
  const int status = glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found);
  if (status == GLOB_NOSPACE) throw_resource("out of memory", {.file = pattern});
  std::vector<std::string> files;
  for (std::size_t i = 0; status == 0 && i < found.gl_pathc; ++i)
    if (!is_directory(found.gl_pathv[i]) && !tells_of_scans(found.gl_pathv[i]))
      files.emplace_back(found.gl_pathv[i]);
  std::sort(files.begin(), files.end());
  return files;
}

/// The other one of a capital and a small letter of ASCII; any other character as it stands.
char in_other_case(char c) {
  constexpr char kStep = 'a' - 'A';
  if (c >= 'a' && c <= 'z') return static_cast<char>(c - kStep);
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c + kStep) : c;
}

/// The end of a set such as "[sz]" that begins at `open`: the place of its "]", which may be the
/// first of its members as well. npos: this begins no set.
std::size_t end_of_set(const std::string& pattern, std::size_t open) {
  std::size_t first = open + 1;
  if (first < pattern.size() && (pattern[first] == '!' || pattern[first] == '^')) ++first;
  return pattern.find(']', first + 1);
}

/// A pattern for the same names in any case: "a[sz]" becomes "[aA][szSZ]".
std::string in_any_case(const std::string& pattern) {
  std::string any;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char c = pattern[i];
    const std::size_t end = c == '[' ? end_of_set(pattern, i) : std::string::npos;
    if (c == '\\' && i + 1 < pattern.size()) {
      any += {c, pattern[++i]};
    } else if (end != std::string::npos) {
      const std::size_t members = i + (pattern[i + 1] == '!' || pattern[i + 1] == '^' ? 2 : 1);
      any += pattern.substr(i, end - i);
      for (const char member : pattern.substr(members, end - members)) any += in_other_case(member);
      any += ']';
      i = end;
    } else if (in_other_case(c) != c) {
      any += {'[', c, in_other_case(c), ']'};
    } else {
      any += c;
    }
  }
  return any;
}

/// Of the last part of the path: folders are where they are.
std::vector<std::string> matches_in_any_case(const std::string& pattern) {
  const std::size_t name = pattern.find_last_of('/') + 1;
  return matches(pattern.substr(0, name) + in_any_case(pattern.substr(name)));
}

/// ** of other programs are folders at any depth; here they would be those of one depth, and the
/// scans of others be passed over without a word.
void refuse_any_depth(const std::string& pattern) {
  if (!pattern.starts_with("**/") && pattern.find("/**/") == std::string::npos) return;
  throw_usage("a pattern does not search folders within folders",
              {.file = pattern,
               .found = "**",
               .expected = "a pattern for each depth, such as scans/*.las and scans/*/*.las"});
}

std::vector<std::string> expand(const std::string& pattern) {
  if (!is_glob(pattern) || is_there(pattern)) return {pattern};
  refuse_any_depth(pattern);
  std::vector<std::string> files = matches(pattern);
  if (!files.empty()) return files;
  const std::vector<std::string> others = matches_in_any_case(pattern);
  throw_usage("no file matches this pattern",
              {.file = pattern,
               .advice = others.empty() ? "Check the folder and the spelling."
                                        : "Capital and small letters differ: " + others.front() +
                                              " is there."});
}

}  // namespace

bool is_glob(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

std::string escape_glob(const std::string& path) {
  std::string escaped;
  for (const char c : path) {
    if (std::string("*?[\\").find(c) != std::string::npos) escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::vector<std::string> expand_globs(const std::vector<std::string>& patterns) {
  std::vector<std::string> files;
  std::unordered_set<std::string> seen;
  for (const std::string& pattern : patterns)
    for (std::string& file : expand(pattern))
      if (seen.insert(file).second) files.push_back(std::move(file));
  return files;
}

std::vector<std::string> files_in_other_case(const std::vector<std::string>& patterns) {
  std::vector<std::string> taken, all;
  for (const std::string& pattern : patterns) {
    if (!is_glob(pattern) || is_there(pattern)) {
      taken.push_back(pattern);
      continue;
    }
    std::ranges::move(matches(pattern), std::back_inserter(taken));
    std::ranges::move(matches_in_any_case(pattern), std::back_inserter(all));
  }
  std::ranges::sort(taken);
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  std::vector<std::string> others;
  std::ranges::set_difference(all, taken, std::back_inserter(others));
  return others;
}

}  // namespace orbweave
