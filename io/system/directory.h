// Directories: what they hold, and their names on the device.
#pragma once

#include <filesystem>
#include <system_error>
#include <vector>

namespace orbweave {

/// What a directory holds, sorted, each with the name of the directory. `error` says what went
/// wrong, a directory that is absent included.
std::vector<std::filesystem::path> entries_of(const std::filesystem::path& directory,
                                              std::error_code& error);

/// Flushes the names in a directory to the device. Returns errno of a failure; 0 where that was
/// done, or where the file system has no flush for directories and says so.
int flush_directory(const std::filesystem::path& directory);

}  // namespace orbweave
