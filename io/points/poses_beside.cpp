#include "io/points/poses_beside.h"

#include <cstdint>
#include <fstream>
#include <set>
#include <system_error>
#include <utility>

#include "io/system/directory.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

bool may_hold_poses(const fs::path& file) {
  constexpr std::uintmax_t kMostBytes = 1 << 20;
  const fs::path extension = file.extension();
  if (extension != ".conf" && extension != ".aln") return false;
  std::error_code failed;
  return fs::is_regular_file(file, failed) && fs::file_size(file, failed) <= kMostBytes && !failed;
}

/// The first word of the file that is the name of a scan; empty: none is.
std::string scan_named_in(const fs::path& file, const std::set<std::string>& names) {
  std::ifstream text(file);
  std::string word;
  while (text >> word) {
    std::string name = fs::path(word).filename().string();
    if (names.contains(name)) return name;
  }
  return {};
}

}  // namespace

std::optional<PosesBeside> poses_beside(std::span<const std::string> scans) {
  std::set<std::string> names;
  std::set<fs::path> folders;
  for (const fs::path scan : scans) {
    names.insert(scan.filename().string());
    folders.insert(scan.has_parent_path() ? scan.parent_path() : fs::path("."));
  }
  for (const fs::path& folder : folders) {
    std::error_code failed;
    for (const fs::path& beside : entries_of(folder, failed)) {
      if (!may_hold_poses(beside)) continue;
      std::string scan = scan_named_in(beside, names);
      if (!scan.empty()) return PosesBeside{beside, std::move(scan)};
    }
  }
  return {};
}

}  // namespace orbweave
