// The paths of a command: what each is for, and whether two of them are one place on disk.
//
// A path is resolved once: through all its links, to device and inode where something is there,
// to the nearest folder that is there and the names below it where nothing is. So "a.ply",
// "./x/../a.ply", a link and a hard link to it are one file.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace orbweave {

/// What happens to a path.
enum class PathUse {
  kReadFile,
  kReadDirectory,     ///< has to stay what it is: the current directory
  kWrittenFile,       ///< made anew, or replaced by name
  kWrittenDirectory,  ///< made anew, or replaced with all that the program wrote there
  kWorkDirectory      ///< filled and removed
};

/// A path and what it is for. Empty paths and "-", a stream, are no places.
struct PathRole {
  std::string role;  ///< for people: "the report"
  std::filesystem::path path;
  PathUse use = PathUse::kReadFile;
  /// Lies in the work directory on purpose: its log.
  bool in_work_directory = false;
  /// False: written only where the input asks for it, which is not known yet.
  bool is_certain = true;
};

/// Throws Error (usage), naming both roles and paths, where two paths collide: a file that is
/// written is read or written a second time, or anything else lies in a directory that is removed
/// or replaced. Devices and pipes may have several roles. Changes nothing.
void check_collisions(std::span<const PathRole> paths);

/// The same, and that everything can be written: throws Error (usage) where a directory is in the
/// place of a file or the other way round and where a link leads nowhere but to itself; (resource)
/// where the folder of an output is not there or cannot be written to. Changes nothing.
void check_paths(std::span<const PathRole> paths);

/// The file that a path stands for: links of the last name are followed, also to a file that is not
/// there yet. Throws Error (usage) where links lead in a circle.
std::filesystem::path final_target(const std::filesystem::path& path);

}  // namespace orbweave
