#include "io/system/glob.h"

#include <glob.h>

#include <algorithm>
#include <filesystem>
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

std::vector<std::string> expand(const std::string& pattern) {
  if (!is_glob(pattern) || is_there(pattern)) return {pattern};
  std::vector<std::string> files = matches(pattern);
  if (files.empty())
    throw_usage("no file matches this pattern",
                {.file = pattern, .advice = "Check the folder and the spelling."});
  return files;
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

}  // namespace orbweave
