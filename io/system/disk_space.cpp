#include "io/system/disk_space.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#ifdef __linux__
#include <sys/quota.h>
#include <sys/syscall.h>
#endif

#include "io/error.h"
#include "io/system/file_descriptor.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kBlockBytes = 4096;

#if defined(__linux__) && defined(SYS_quotactl_fd)
/// Lowers `free` to what a quota leaves; where there is no quota, or the quota is unknown, nothing
/// happens.
void apply_quota(int directory, int kind, unsigned id, FreeSpace& free) {
  constexpr std::uint64_t kQuotaBlock = 1024;
  dqblk quota{};
  if (syscall(SYS_quotactl_fd, directory, QCMD(Q_GETQUOTA, kind), id, &quota) != 0) return;
  const std::uint64_t limit = std::max(quota.dqb_bhardlimit, quota.dqb_bsoftlimit) * kQuotaBlock;
  if ((quota.dqb_valid & QIF_BLIMITS) == 0 || limit == 0) return;
  const std::uint64_t left = limit - std::min<std::uint64_t>(limit, quota.dqb_curspace);
  if (left >= free.bytes) return;
  free.bytes = left;
  free.limited_by_quota = true;
}

void apply_quotas(const std::filesystem::path& directory, FreeSpace& free) {
  const FileDescriptor opened(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!opened.valid()) return;
  apply_quota(opened.get(), USRQUOTA, geteuid(), free);
  apply_quota(opened.get(), GRPQUOTA, getegid(), free);
}
#else
void apply_quotas(const std::filesystem::path&, FreeSpace&) {}
#endif

std::filesystem::path nearest_directory(const std::filesystem::path& path) {
  std::error_code ignored;
  std::filesystem::path at = std::filesystem::absolute(path, ignored).lexically_normal();
  while (!std::filesystem::is_directory(at, ignored) && at != at.parent_path())
    at = at.parent_path();
  return at;
}

}  // namespace

void DiskUsage::add(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  now_ += bytes;
  most_ = std::max(most_, now_);
}

void DiskUsage::remove(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  now_ -= std::min(now_, bytes);
}

void DiskUsage::set(std::uint64_t bytes) {
  const std::scoped_lock lock(mutex_);
  now_ = bytes;
  most_ = std::max(most_, now_);
}

std::uint64_t DiskUsage::now() const {
  const std::scoped_lock lock(mutex_);
  return now_;
}

std::uint64_t DiskUsage::most() const {
  const std::scoped_lock lock(mutex_);
  return most_;
}

std::uint64_t room_of_file(std::uint64_t bytes) {
  return (bytes + kBlockBytes - 1) / kBlockBytes * kBlockBytes;
}

namespace {

/// What was given back inside of a large file is no longer taken.
std::uint64_t room_of_entry(const std::filesystem::path& path, std::uint64_t bytes) {
  constexpr std::uint64_t kLarge = std::uint64_t{1} << 20;
  constexpr std::uint64_t kStatBlock = 512;
  const std::uint64_t room = room_of_file(bytes);
  struct stat facts {};
  if (bytes < kLarge || stat(path.c_str(), &facts) != 0) return room;
  return std::min(room, static_cast<std::uint64_t>(facts.st_blocks) * kStatBlock);
}

}  // namespace

std::uint64_t room_of_directory(const std::filesystem::path& directory) {
  namespace fs = std::filesystem;
  std::uint64_t bytes = 0;
  std::error_code error;
  const auto options = fs::directory_options::skip_permission_denied;
  for (fs::recursive_directory_iterator entry(directory, options, error), end;
       !error && entry != end; entry.increment(error)) {
    std::error_code gone;  // files may be renamed or removed meanwhile
    const std::uint64_t size = entry->is_regular_file(gone) ? entry->file_size(gone) : 0;
    if (!gone) bytes += room_of_entry(entry->path(), size);
  }
  return bytes;
}

FreeSpace free_space(const std::filesystem::path& path) {
  const std::filesystem::path directory = nearest_directory(path);
  struct statvfs facts {};
  struct stat place {};
  if (statvfs(directory.c_str(), &facts) != 0 || stat(directory.c_str(), &place) != 0)
    throw_resource("cannot find out how much room there is",
                   {.file = directory.string(), .found = std::strerror(errno)});
  FreeSpace free;
  free.bytes = static_cast<std::uint64_t>(facts.f_bavail) * facts.f_frsize;
  free.device = place.st_dev;
  apply_quotas(directory, free);
  return free;
}

}  // namespace orbweave
