#include "io/store_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <fstream>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "io/error.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::string_view kMemberLock = "member.";
/// Who asks for the state of a work directory holds a lock for a moment.
constexpr milliseconds kMoment{50};
constexpr milliseconds kPause{10};

[[noreturn]] void throw_lock_error(const fs::path& path, int reason) {
  throw_resource("cannot use the work directory",
                 {.file = path.string(),
                  .found = std::strerror(reason),
                  .advice = "Name another with run.work_dir or --work-dir"});
}

std::string first_line(const fs::path& path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

/// False where the name has gone to another file, or to none, since `file` was opened: then a lock
/// is on nothing.
bool has_name(const FileDescriptor& file, const fs::path& path) {
  struct stat held {
  }, named{};
  if (fstat(file.get(), &held) != 0 || ::stat(path.c_str(), &named) != 0) {
    if (errno != ENOENT) throw_lock_error(path, errno);
    return false;
  }
  return held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

/// The lock, or nothing where somebody else holds it all the time that may be waited.
std::optional<FileDescriptor> try_lock(const fs::path& path, milliseconds patience) {
  const auto give_up = steady_clock::now() + patience;
  for (;;) {
    FileDescriptor file(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
    if (!file.valid()) {
      if (errno == EINTR) continue;
      throw_lock_error(path, errno);
    }
    if (flock(file.get(), LOCK_EX | LOCK_NB) == 0) {
      if (has_name(file, path)) return file;
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) throw_lock_error(path, errno);
    if (steady_clock::now() >= give_up) return std::nullopt;
    std::this_thread::sleep_for(kPause);
  }
}

void write_line(const FileDescriptor& file, const fs::path& path, const std::string& line) {
  const std::string text = line + "\n";
  const auto size = static_cast<off_t>(text.size());
  if (pwrite(file.get(), text.data(), text.size(), 0) != size || ftruncate(file.get(), size) != 0)
    throw_lock_error(path, errno);
}

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

std::vector<fs::path> member_locks(const fs::path& directory) {
  std::vector<fs::path> locks;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, ignored))
    if (entry.path().filename().native().starts_with(kMemberLock)) locks.push_back(entry.path());
  std::sort(locks.begin(), locks.end());
  return locks;
}

std::string member_name(const fs::path& lock) {
  const std::string rank = lock.filename().string().substr(kMemberLock.size());
  return "rank " + rank + " (process " + first_line(lock) + ")";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// Returns when no member of an earlier team is left.
void await_members(const fs::path& directory, milliseconds patience) {
  const auto give_up = steady_clock::now() + patience;
  std::vector<std::string> left;
  for (const fs::path& path : member_locks(directory)) {
    const auto rest = std::chrono::duration_cast<milliseconds>(give_up - steady_clock::now());
    const std::optional<FileDescriptor> lock = try_lock(path, std::max(rest, kMoment));
    if (lock)
      ::unlink(path.c_str());
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

FileDescriptor lock_as_owner(const fs::path& directory, milliseconds patience) {
  const fs::path path = directory / kOwnerLock;
  const fs::path mark = directory / kTeamMark;
  std::optional<FileDescriptor> lock = try_lock(path, kMoment);
  std::error_code ignored;
  // The leader of a team ends no faster than its members where mpirun has to kill it.
  if (!lock && fs::exists(mark, ignored)) lock = try_lock(path, patience);
  if (!lock)
    throw_resource("the work directory is in use by process " + first_line(path),
                   {.file = directory.string(),
                    .advice = "Wait for it, or name another with run.work_dir or --work-dir"});
  write_line(*lock, path, std::to_string(getpid()));
  // A member locks first and looks for the mark afterwards: it is seen here, or does not join.
  ::unlink(mark.c_str());
  await_members(directory, patience);
  return std::move(*lock);
}

FileDescriptor lock_as_member(const fs::path& directory, int rank, milliseconds patience) {
  const fs::path path = directory / (std::string(kMemberLock) + std::to_string(rank));
  std::optional<FileDescriptor> lock = try_lock(path, std::max(patience, kMoment));
  if (!lock)
    throw_resource(
        "another process has this one's place in the work directory: " + member_name(path),
        {.file = directory.string(), .advice = "End it and repeat the command, which resumes"});
  write_line(*lock, path, std::to_string(getpid()) + " on " + host_name());
  return std::move(*lock);
}

bool is_lock_file(const fs::path& name) {
  return name == kOwnerLock || name.native().starts_with(kMemberLock);
}

std::vector<std::string> members_at_work(const fs::path& directory) {
  std::vector<std::string> members;
  for (const fs::path& path : member_locks(directory)) {
    const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file.valid()) continue;
    const bool held = flock(file.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (held) members.push_back(member_name(path));
  }
  return members;
}

}  // namespace orbweave
