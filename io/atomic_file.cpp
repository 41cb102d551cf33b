#include "io/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "io/error.h"
#include "io/temporary_name.h"

namespace orbweave {
namespace {

// Write-back starts this early, so that the flush at the end finds little left to do.
constexpr std::uint64_t kFlushBytes = std::uint64_t{16} << 20;
constexpr mode_t kFileMode = 0666;  // the process's umask applies

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path target) : target_(std::move(target)) {
  struct stat facts {};
  const bool exists = ::stat(target_.c_str(), &facts) == 0;
  if (exists && S_ISDIR(facts.st_mode)) {
    errno = EISDIR;
    fail("cannot write the file");
  }
  if (exists && !S_ISREG(facts.st_mode))
    open_target_itself();
  else
    open_temporary();
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::open_target_itself() {
  descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor_ < 0) fail("cannot write the file");
}

void AtomicFile::open_temporary() {
  for (;;) {
    temporary_ = temporary_beside(target_);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode);
    if (descriptor_ < 0 && errno == EEXIST) continue;
    if (descriptor_ < 0) fail("cannot write the file");
    if (keep_temporary(descriptor_)) return;
    ::close(std::exchange(descriptor_, -1));
  }
}

void AtomicFile::write(std::span<const std::byte> bytes) { write_all(bytes.data(), bytes.size()); }

void AtomicFile::write(std::string_view text) {
  write_all(reinterpret_cast<const std::byte*>(text.data()), text.size());
}

void AtomicFile::write_all(const std::byte* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t wrote = ::write(descriptor_, bytes, count);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote < 0) fail("cannot write the file");
    bytes += wrote;
    count -= static_cast<std::size_t>(wrote);
    bytes_written_ += static_cast<std::uint64_t>(wrote);
  }
#ifdef __linux__
  if (!temporary_.empty() && bytes_written_ - bytes_flushing_ >= kFlushBytes) {
    // Only a hint: where it does not work, commit's fsync does all of it.
    ::sync_file_range(descriptor_, static_cast<off64_t>(bytes_flushing_),
                      static_cast<off64_t>(bytes_written_ - bytes_flushing_),
                      SYNC_FILE_RANGE_WRITE);
    bytes_flushing_ = bytes_written_;
  }
#endif
}

void AtomicFile::commit() {
  if (temporary_.empty()) {
    if (::close(std::exchange(descriptor_, -1)) != 0) fail("cannot write the file");
    return;
  }
  if (::fsync(descriptor_) != 0) fail("cannot flush the file");
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("cannot name the file");
  ::close(std::exchange(descriptor_, -1));
  // Without this the name itself may be lost in a power cut. Some file systems refuse to flush a
  // directory; the file is whole all the same.
  const int directory = ::open(directory_of(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory < 0) return;
  ::fsync(directory);
  ::close(directory);
}

void AtomicFile::fail(const char* problem) const {
  const std::string reason = std::system_category().message(errno);
  throw_resource(problem + (": " + reason),
                 {.file = target_.string(), .advice = "Make room there, or write it elsewhere"});
}

void remove_abandoned(const std::filesystem::path& target) {
  const std::string stem = target.stem().string();
  std::error_code ignored;
  std::vector<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::directory_iterator(directory_of(target), ignored)) {
    if (is_temporary_of(entry.path().filename().string(), stem)) found.push_back(entry.path());
  }
  for (const std::filesystem::path& path : found) {
    // For writing: over a network the lock asks for that.
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW);
    if (descriptor < 0) continue;
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) ::unlink(path.c_str());
    ::close(descriptor);
  }
}

}  // namespace orbweave
