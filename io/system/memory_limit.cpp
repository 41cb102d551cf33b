#include "io/system/memory_limit.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>

#include "io/system/small_file.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = std::size_t{1} << 16;

/// The number at the beginning; nothing where there is none, such as in "max".
std::optional<std::uint64_t> number_at(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
  std::uint64_t value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc() ? std::optional(value) : std::nullopt;
}

void take_less(std::optional<std::uint64_t>& least, std::optional<std::uint64_t> other) {
  if (other && (!least || *other < *least)) least = other;
}

/// The limits of a control group and of those above it. A container may see its own group as the
/// outermost one, under another name.
std::optional<std::uint64_t> limit_of_group(const fs::path& mount, std::string_view group,
                                            const char* file) {
  std::optional<std::uint64_t> least;
  for (std::string path(group);; path.resize(std::min(path.rfind('/'), path.size()))) {
    if (const auto text = small_file_text(mount.string() + path + "/" + file, kMostBytes))
      take_less(least, number_at(*text));
    if (path.empty() || path == "/") return least;
  }
}

std::optional<std::uint64_t> limit_of_groups(const fs::path& root) {
  std::optional<std::uint64_t> least;
  const std::string text = small_file_text(root / "proc/self/cgroup", kMostBytes).value_or("");
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    // "4:memory:/path" of version 1, "0::/path" of version 2.
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string_view::npos) continue;
    const std::string_view kinds = line.substr(first + 1, second - first - 1);
    const std::string_view group = line.substr(second + 1);
    if (kinds.empty())
      take_less(least, limit_of_group(root / "sys/fs/cgroup", group, "memory.max"));
    else if (("," + std::string(kinds) + ",").find(",memory,") != std::string::npos)
      take_less(least,
                limit_of_group(root / "sys/fs/cgroup/memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

std::optional<std::uint64_t> memory_of_machine(const fs::path& root) {
  constexpr std::string_view kName = "MemTotal:";
  constexpr std::uint64_t kKibibyte = 1024;
  const std::string text = small_file_text(root / "proc/meminfo", kMostBytes).value_or("");
  const std::size_t at = text.find(kName);
  if (at == std::string::npos) return std::nullopt;
  const auto kibibytes = number_at(std::string_view(text).substr(at + kName.size()));
  return kibibytes ? std::optional(*kibibytes * kKibibyte) : std::nullopt;
}

}  // namespace

std::optional<std::uint64_t> memory_limit_bytes(const fs::path& root) {
  std::optional<std::uint64_t> least = memory_of_machine(root);
  take_less(least, limit_of_groups(root));
  return least;
}

}  // namespace orbweave
