#include "io/store/store_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "io/error.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/small_file.h"
#include "io/system/work_directory_errors.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::string_view kMemberLock = "member.";
/// Ends the line of every file here, with the id of the store in between: a file with another end
/// is a stranger's.
constexpr std::string_view kOwner = " (orbweave ";
constexpr std::string_view kOwnerEnd = ")\n";
/// Who asks for the state of a work directory holds a lock for a moment.
constexpr milliseconds kMoment{50};
constexpr milliseconds kPause{10};

struct LockText {
  std::string line;
  std::string store;
};

/// Empty: no lock holds that.
std::optional<LockText> parts_of(const fs::path& path) {
  constexpr std::uintmax_t kMostBytes = 512;
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(path, error)) ||
      fs::file_size(path, error) > kMostBytes || error)
    return std::nullopt;
  const std::string text = small_file_text(path).value_or("");
  const std::size_t owner = text.rfind(kOwner);
  if (owner == std::string::npos || !text.ends_with(kOwnerEnd) ||
      text.find('\n') + 1 != text.size())
    return std::nullopt;
  const std::size_t store = owner + kOwner.size();
  return LockText{text.substr(0, owner),
                  text.substr(store, text.size() - kOwnerEnd.size() - store)};
}

/// "member." and the digits of a rank.
bool is_member_name(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with(kMemberLock) && name.size() > kMemberLock.size() &&
         name.find_first_not_of("0123456789", kMemberLock.size()) == std::string::npos;
}

/// Nothing is in a lock that was just made.
bool is_empty_file(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(fs::symlink_status(path, error)) && fs::file_size(path, error) == 0 &&
         !error;
}

void remove_lock(const fs::path& path, const std::string& store, const IsOnRecord& is_ours) {
  if (is_lock_file(path, store) || (is_ours && is_ours(path))) ::unlink(path.c_str());
}

/// False where the name has gone to another file, or to none, since `file` was opened: then a lock
/// is on nothing.
bool has_name(const FileDescriptor& file, const fs::path& path) {
  struct stat held {
  }, named{};
  if (fstat(file.get(), &held) != 0 || ::stat(path.c_str(), &named) != 0) {
    if (errno != ENOENT) throw_directory_error(path, errno);
    return false;
  }
  return held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

/// The lock, or nothing where another process holds it all the time that may be waited.
std::optional<FileDescriptor> try_lock(const fs::path& path, milliseconds patience) {
  const auto give_up = steady_clock::now() + patience;
  for (;;) {
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (!file.valid()) {
      if (errno == EINTR) continue;
      if (errno == EISDIR || errno == ELOOP) throw_stranger(path);
      throw_directory_error(path, errno);
    }
    if (flock(file.get(), LOCK_EX | LOCK_NB) == 0) {
      if (has_name(file, path)) return file;
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) throw_directory_error(path, errno);
    if (steady_clock::now() >= give_up) return std::nullopt;
    std::this_thread::sleep_for(kPause);
  }
}

void write_line(const FileDescriptor& file, const fs::path& path, const std::string& line,
                const std::string& store) {
  const std::string text = lock_text(line, store);
  const auto size = static_cast<off_t>(text.size());
  errno = 0;  // a write that is cut short sets none
  if (file_calls.pwrite(file.get(), text.data(), text.size(), 0) != size ||
      file_calls.ftruncate(file.get(), size) != 0)
    throw_directory_error(path, errno != 0 ? errno : ENOSPC);
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

std::vector<fs::path> member_locks(const fs::path& directory) {
  std::vector<fs::path> locks;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, ignored))
    if (is_member_name(entry.path()) &&
        (is_lock_file(entry.path(), {}) || is_empty_file(entry.path())))
      locks.push_back(entry.path());
  std::sort(locks.begin(), locks.end());
  return locks;
}

std::string member_name(const fs::path& lock) {
  const std::string rank = lock.filename().string().substr(kMemberLock.size());
  return "rank " + rank + " (process " + line_of_lock(lock) + ")";
}

/// Whether another process holds the lock. It is taken for a moment where none does.
bool is_held(const FileDescriptor& file) {
  return flock(file.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// Returns when no member of an earlier team is left.
void await_members(const fs::path& directory, const std::string& store, milliseconds patience,
                   const IsOnRecord& is_ours) {
  const auto give_up = steady_clock::now() + patience;
  std::vector<std::string> left;
  for (const fs::path& path : member_locks(directory)) {
    const auto rest = std::chrono::duration_cast<milliseconds>(give_up - steady_clock::now());
    const std::optional<FileDescriptor> lock = try_lock(path, std::max(rest, kMoment));
    if (lock)
      remove_lock(path, store, is_ours);
    else
      left.push_back(member_name(path));
  }
  if (left.empty()) return;
  throw_resource("a run before this one has ended, but not all of its processes: " + joined(left),
                 {.file = directory.string(),
                  .advice = "End them and repeat the command, which resumes; or name another "
                            "directory with run.work_dir or --work-dir"});
}

}  // namespace

FileDescriptor lock_as_owner(const fs::path& directory, const std::string& store,
                             milliseconds patience, const IsOnRecord& is_ours) {
  const fs::path path = directory / kOwnerLock;
  const fs::path mark = directory / kTeamMark;
  std::optional<FileDescriptor> lock = try_lock(path, kMoment);
  std::error_code ignored;
  // The leader of a team ends no faster than its members where mpirun has to kill it.
  if (!lock && fs::exists(mark, ignored)) lock = try_lock(path, patience);
  if (!lock)
    throw_resource("the work directory is in use by process " + line_of_lock(path),
                   {.file = directory.string(),
                    .advice = "Wait for it, or name another with run.work_dir or --work-dir"});
  // A removal that was cut short leaves the lock of a store whose id is gone.
  if (!is_lock_file(path, {}) && !is_empty_file(path) && !(is_ours && is_ours(path)))
    throw_stranger(path);
  write_line(*lock, path, std::to_string(getpid()), store);
  // A member locks first and looks for the mark afterwards: it is seen here, or does not join.
  remove_lock(mark, store, is_ours);
  await_members(directory, store, patience, is_ours);
  return std::move(*lock);
}

fs::path member_lock(const fs::path& directory, int rank) {
  return directory / (std::string(kMemberLock) + std::to_string(rank));
}

FileDescriptor lock_as_member(const fs::path& directory, int rank, const std::string& store,
                              milliseconds patience, const IsOnRecord& is_ours) {
  const fs::path path = member_lock(directory, rank);
  std::optional<FileDescriptor> lock = try_lock(path, std::max(patience, kMoment));
  if (!lock)
    throw_resource(
        "another process has this one's place in the work directory: " + member_name(path),
        {.file = directory.string(), .advice = "End it and repeat the command, which resumes"});
  const bool on_record = is_ours ? is_ours(path) : is_empty_file(path);
  if (!is_lock_file(path, store) && !on_record) throw_stranger(path);
  write_line(*lock, path, std::to_string(getpid()) + " on " + host_name(), store);
  return std::move(*lock);
}

std::string lock_text(const std::string& line, const std::string& store) {
  return line + std::string(kOwner) + store + std::string(kOwnerEnd);
}

std::string line_of_lock(const fs::path& path) {
  const std::optional<LockText> parts = parts_of(path);
  return parts ? parts->line : std::string();
}

bool is_lock_file(const fs::path& path, const std::string& store) {
  const fs::path name = path.filename();
  if (name != kOwnerLock && name != kTeamMark && !is_member_name(path)) return false;
  const std::optional<LockText> parts = parts_of(path);
  return parts && (store.empty() || parts->store == store);
}

bool is_owned(const fs::path& directory) {
  const FileDescriptor file(::open((directory / kOwnerLock).c_str(), O_RDONLY | O_CLOEXEC));
  return file.valid() && is_held(file);
}

std::vector<std::string> members_at_work(const fs::path& directory) {
  std::vector<std::string> members;
  for (const fs::path& path : member_locks(directory)) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) continue;
    if (is_held(file)) members.push_back(member_name(path));
  }
  return members;
}

}  // namespace orbweave
