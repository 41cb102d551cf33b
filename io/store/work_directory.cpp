#include "io/store/work_directory.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <system_error>

#include "io/store/result_identity.h"
#include "io/store/store_lock.h"
#include "io/system/file_calls.h"
#include "io/system/file_descriptor.h"
#include "io/system/owned_files.h"
#include "io/system/path_roles.h"
#include "io/system/work_directory_errors.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kAsideBegin = ".orbweave.";
constexpr std::string_view kAsideEnd = ".part";
constexpr std::size_t kAsideDigits = 16;
constexpr mode_t kDirectoryMode = 0777;  // the process's umask applies

/// The name beside `place`: a random number, and a checksum of it and the place, so that no
/// directory of a stranger has such a name by chance.
fs::path aside_of(const fs::path& place, std::uint32_t number) {
  const std::string& text = place.native();
  const auto check =
      static_cast<std::uint32_t>(XXH3_64bits_withSeed(text.data(), text.size(), number));
  std::array<char, kAsideDigits + 1> digits{};
  std::snprintf(digits.data(), digits.size(), "%08x%08x", number, check);
  return place.parent_path() / (std::string(kAsideBegin) + digits.data() + std::string(kAsideEnd));
}

bool is_aside_of(const fs::path& place, const fs::path& entry) {
  const std::string name = entry.filename().string();
  if (name.size() != kAsideBegin.size() + kAsideDigits + kAsideEnd.size() ||
      !name.starts_with(kAsideBegin))
    return false;
  const char* const digits = name.data() + kAsideBegin.size();
  std::uint32_t number = 0;
  std::from_chars(digits, digits + kAsideDigits / 2, number, 16);
  return aside_of(place, number).filename() == entry.filename();
}

std::optional<struct stat> facts_of(const fs::path& path) {
  struct stat facts {};
  return ::lstat(path.c_str(), &facts) == 0 ? std::optional(facts) : std::nullopt;
}

/// The directory, locked for this process; not valid where it is gone or another process is at it.
FileDescriptor hold(const fs::path& aside) {
  FileDescriptor held(::open(aside.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  if (!held.valid()) return held;
  // A file system that knows no such locks leaves it to the renaming.
  if (flock(held.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return FileDescriptor();
  struct stat facts {};
  const std::optional<struct stat> named = facts_of(aside);
  const bool is_there = named && ::fstat(held.get(), &facts) == 0 && facts.st_ino == named->st_ino;
  return is_there ? std::move(held) : FileDescriptor();
}

/// Removes what runs that were killed left beside the place.
void remove_asides(const fs::path& place) {
  std::error_code error;
  std::vector<fs::path> asides;
  for (const fs::directory_entry& entry : fs::directory_iterator(place.parent_path(), error))
    if (is_aside_of(place, entry.path())) asides.push_back(entry.path());
  for (const fs::path& aside : asides) {
    const std::optional<struct stat> facts = facts_of(aside);
    const bool may_be = facts && S_ISDIR(facts->st_mode) && facts->st_uid == geteuid();
    if (may_be && hold(aside).valid()) remove_aside(aside);
  }
}

/// False where something has that name already; errno says why not.
bool rename_to_free_name(const fs::path& from, const fs::path& to) {
#ifdef RENAME_NOREPLACE
  if (file_calls.renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0)
    return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
#endif
  if (facts_of(to)) {
    errno = EEXIST;
    return false;
  }
  return file_calls.rename(from.c_str(), to.c_str()) == 0;
}

/// Makes one directory; false where it is there.
bool make_one(const fs::path& path, std::vector<MadeDirectory>& made) {
  if (::mkdir(path.c_str(), kDirectoryMode) != 0) {
    if (errno == EEXIST) return false;
    throw_directory_error(path, errno);
  }
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) throw_directory_error(path, errno);
  made.push_back({facts.st_ino, path.string()});
  return true;
}

/// A new directory beside the place, held by this process.
std::pair<fs::path, FileDescriptor> make_aside(const fs::path& place) {
  std::random_device device;
  for (;;) {
    const fs::path aside = aside_of(place, device());
    if (::mkdir(aside.c_str(), kDirectoryMode) != 0) {
      if (errno == EEXIST) continue;
      throw_directory_error(place, errno);
    }
    errno = 0;
    FileDescriptor held = hold(aside);
    if (held.valid()) return {aside, std::move(held)};
    if (errno != 0 && errno != ENOENT && errno != EWOULDBLOCK) {
      const int reason = errno;
      remove_aside(aside);
      throw_directory_error(place, reason);
    }
  }
}

/// Makes the work directory itself.
void make_with_identity(const fs::path& place, std::vector<MadeDirectory>& made) {
  const auto [aside, held] = make_aside(place);
  try {
    struct stat facts {};
    if (::fstat(held.get(), &facts) != 0) throw_directory_error(place, errno);
    std::vector<MadeDirectory> all = made;
    all.push_back({facts.st_ino, place.string()});
    write_identity(aside, {StoreIdentity::State::kSound, new_id(), all, {}}, true, place);
    if (rename_to_free_name(aside, place)) {
      made = std::move(all);
      return;
    }
    if (errno != EEXIST && errno != ENOTEMPTY && errno != ENOTDIR)
      throw_directory_error(place, errno);
  } catch (...) {
    remove_aside(aside);
    throw;
  }
  remove_aside(aside);  // another process was faster
}

}  // namespace

std::vector<MadeDirectory> make_work_directory(const fs::path& directory) {
  std::error_code error;
  const fs::path path = fs::weakly_canonical(fs::absolute(final_target(directory)), error);
  if (error) throw_directory_error(directory, error.value());
  std::vector<fs::path> missing;
  for (fs::path folder = path; !fs::exists(folder, error) && !error && folder.has_relative_path();
       folder = folder.parent_path())
    missing.push_back(folder);
  std::vector<MadeDirectory> made;
  for (auto folder = missing.rbegin(); folder != missing.rend(); ++folder) {
    if (*folder != path) {
      make_one(*folder, made);
      continue;
    }
    remove_asides(path);
    make_with_identity(path, made);
  }
  if (!fs::is_directory(path, error)) throw_directory_error(directory, ENOTDIR);
  return made;
}

bool is_made(const fs::path& directory, const std::vector<MadeDirectory>& made) {
  std::error_code ignored;
  const fs::path place = fs::weakly_canonical(directory, ignored);
  struct stat facts {};
  if (::stat(place.c_str(), &facts) != 0) return false;
  return std::ranges::any_of(made, [&](const MadeDirectory& one) {
    return one.inode == facts.st_ino || one.path == place;
  });
}

fs::path put_aside(const fs::path& directory) {
  std::error_code ignored;
  const fs::path place = fs::weakly_canonical(directory, ignored);
  const fs::path aside = aside_of(place, std::random_device()());
  return rename_to_free_name(place, aside) ? aside : fs::path();
}

void remove_aside(const fs::path& aside) {
  constexpr std::array<const char*, 3> kMarks = {kStoreFile, kOwnerLock, kEndedFile};
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(aside, error)) {
    const fs::path name = entry.path().filename();
    const bool is_mark = std::ranges::find(kMarks, name) != kMarks.end();
    const std::optional<struct stat> facts = facts_of(entry.path());
    if (facts && !is_ghost(entry.path()) && (!is_mark || !S_ISREG(facts->st_mode))) return;
  }
  for (const char* name : kMarks) ::unlink((aside / name).c_str());
  ::rmdir(aside.c_str());
}

bool take_back(const fs::path& aside, const fs::path& directory) {
  std::error_code ignored;
  if (!facts_of(aside / kStoreFile)) return false;
  return rename_to_free_name(aside, fs::weakly_canonical(directory, ignored));
}

void remove_made(const fs::path& directory, const std::vector<MadeDirectory>& made) {
  std::error_code ignored;
  const fs::path place = fs::weakly_canonical(directory, ignored);
  const auto remove = [&](const fs::path& path) {
    struct stat facts {};
    if (::stat(path.c_str(), &facts) != 0) return;
    for (const MadeDirectory& one : made)
      if (one.inode == facts.st_ino || (path == place && one.path == place))
        return remove_if_empty(path);
  };
  remove(place);
  for (auto one = made.rbegin(); one != made.rend(); ++one) remove(one->path);
}

}  // namespace orbweave
