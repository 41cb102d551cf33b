#include "engine/pipeline/points/missing_poses.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <system_error>

#include "io/job/setting.h"
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

/// The first word of the file that is the name of a scan; empty: none.
std::string scan_named_in(const fs::path& file, const std::set<std::string>& scans) {
  std::ifstream text(file);
  std::string word;
  while (text >> word) {
    std::string name = fs::path(word).filename().string();
    if (scans.contains(name)) return name;
  }
  return {};
}

}  // namespace

std::string objection_to_missing_poses(const ResolvedJob& job) {
  if (job.files.size() < 2 || !job.poses.empty()) return {};
  std::set<std::string> scans;
  std::set<fs::path> directories;
  for (const fs::path file : job.files) {
    scans.insert(file.filename().string());
    directories.insert(file.has_parent_path() ? file.parent_path() : fs::path("."));
  }
  for (const fs::path& directory : directories) {
    std::error_code failed;
    for (const fs::path& beside : entries_of(directory, failed)) {
      if (!may_hold_poses(beside)) continue;
      const std::string scan = scan_named_in(beside, scans);
      if (scan.empty()) continue;
      const bool can_be_read = beside.extension() == ".conf";
      return "the scans are taken to fit as they are, but " + beside.string() + " names " + scan +
             ": if it holds their poses, give them by " +
             setting_name(job, can_be_read ? "input.poses" : "input.pose");
    }
  }
  return {};
}

}  // namespace orbweave
