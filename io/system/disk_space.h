// Room on disks: how much there is, and how much of it a job holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>

namespace orbweave {

/// What a job holds on disk, and the most it held at one time. Bytes; thread-safe.
class DiskUsage {
 public:
  void add(std::uint64_t bytes);
  void remove(std::uint64_t bytes);
  /// What is held is counted anew.
  void set(std::uint64_t bytes);
  std::uint64_t now() const;
  std::uint64_t most() const;

 private:
  mutable std::mutex mutex_;
  std::uint64_t now_ = 0;
  std::uint64_t most_ = 0;
};

/// The room that a file takes: whole blocks of 4096 bytes.
std::uint64_t room_of_file(std::uint64_t bytes);
/// Of all files below a directory; 0 where there is none.
std::uint64_t room_of_directory(const std::filesystem::path& directory);

struct FreeSpace {
  std::uint64_t bytes = 0;   ///< that this user may still write
  std::uint64_t device = 0;  ///< equal for paths on one file system
  bool limited_by_quota = false;
};
/// Free space where `path` is or will be: of the nearest directory above it that exists. The least
/// of what the file system has left for this user and what the quotas of user and group leave,
/// where the system tells. Throws Error (resource) where nothing can be found out.
FreeSpace free_space(const std::filesystem::path& path);

}  // namespace orbweave
