#include "io/system/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/system/directory.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/path_roles.h"
#include "io/system/system_advice.h"
#include "io/system/temporary_name.h"

namespace orbweave {
namespace {

// Write-back starts this early, so that the flush at the end finds little left to do.
constexpr std::uint64_t kFlushBytes = std::uint64_t{16} << 20;
constexpr mode_t kFileMode = 0666;  // the process's umask applies

/// A file that takes the place of another one is as open to others as that one was. Where the
/// system does not allow it, the file is as new ones are.
void keep_permissions(int descriptor, const std::filesystem::path& target) {
  constexpr mode_t kPermissions = S_IRWXU | S_IRWXG | S_IRWXO;
  struct stat facts {};
  if (::stat(target.c_str(), &facts) == 0 && S_ISREG(facts.st_mode))
    static_cast<void>(::fchmod(descriptor, facts.st_mode & kPermissions));
}

}  // namespace

AtomicFile::AtomicFile(std::filesystem::path target)
    : name_(std::move(target)), target_(final_target(name_)), record_(current_record()) {
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

AtomicFile::AtomicFile(std::filesystem::path target, std::shared_ptr<OwnedFiles> record)
    : name_(std::move(target)), target_(name_), record_(std::move(record)), replaces_any_(false) {
  std::error_code absent;
  if (std::filesystem::exists(std::filesystem::symlink_status(target_, absent)) &&
      !record_->owns(target_))
    throw_stranger(target_);
  open_temporary();
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  ::close(descriptor_);
  if (!temporary_.empty()) remove_temporary();
}

void AtomicFile::remove_temporary() noexcept {
  try {
    if (record_)
      record_->remove(temporary_);
    else
      ::unlink(temporary_.c_str());
  } catch (const std::exception&) {
    // The next run removes it.
  }
}

void AtomicFile::open_target_itself() {
  descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor_ < 0) fail("cannot write the file");
}

void AtomicFile::open_temporary() {
  do {
    temporary_ = temporary_beside(target_);
    descriptor_ = create_temporary();
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) fail("cannot write the file");
  at_risk_.keep(temporary_);
}

int AtomicFile::create_temporary() const {
  if (!record_)
    return ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kFileMode);
  return record_->try_create(temporary_).release();
}

void AtomicFile::give_name() {
  const bool named = record_ ? record_->rename(temporary_, target_, replaces_any_)
                             : file_calls.rename(temporary_.c_str(), target_.c_str()) == 0;
  if (!named) fail("cannot name the file");
}

void AtomicFile::write(std::span<const std::byte> bytes) { write_all(bytes.data(), bytes.size()); }

void AtomicFile::write(std::string_view text) {
  write_all(reinterpret_cast<const std::byte*>(text.data()), text.size());
}

void AtomicFile::write_all(const std::byte* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t wrote = file_calls.write(descriptor_, bytes, count);
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

void AtomicFile::commit(Flush flush) {
  if (temporary_.empty()) {
    if (::close(std::exchange(descriptor_, -1)) != 0) fail("cannot write the file");
    return;
  }
  keep_permissions(descriptor_, target_);
  const bool flushes = flush == Flush::kYes;
  if (flushes && file_calls.fsync(descriptor_) != 0) fail("cannot flush the file");
  give_name();
  at_risk_.forget();
  ::close(std::exchange(descriptor_, -1));
  // Without this the name itself may be lost in a power cut. Some file systems refuse to flush a
  // directory; the file is whole all the same.
  if (flushes) flush_directory(directory_of(target_));
}

void AtomicFile::fail(const char* problem) const {
  const int error = errno;
  throw_resource(problem + (": " + system_reason(error)),
                 {.file = name_.string(), .advice = advice_on(error)});
}

}  // namespace orbweave
