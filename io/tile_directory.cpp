#include "io/tile_directory.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "io/error.h"
#include "io/temporary_name.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& target, const std::error_code& reason) {
  throw_resource("cannot write the tiles", {.file = target.string(),
                                            .place = {},
                                            .found = reason.message(),
                                            .expected = {},
                                            .advice = "Make room there, or name another mesh"});
}

[[noreturn]] void fail_of_system(const fs::path& target) {
  fail(target, std::error_code(errno, std::system_category()));
}

bool is_tile(std::string_view name) {
  const std::size_t digits = std::min(name.find_first_not_of("0123456789"), name.size());
  name.remove_prefix(digits);
  return digits >= 6 && (name == ".ply" || name == ".ply.gz");
}

/// A tile, the index, or either on its way.
bool is_ours(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  std::error_code unreadable;
  if (!entry.is_regular_file(unreadable)) return false;
  return is_tile(name) || name == kTileIndex || (name.starts_with('.') && name.ends_with(".part"));
}

/// Removes a directory of tiles; anything else in it stays, and so does the directory then.
void remove_tiles(const fs::path& directory) {
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(directory, ignored)) {
    if (is_ours(entry)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) fs::remove(file, ignored);
  fs::remove(directory, ignored);
}

/// What killed processes left.
void remove_abandoned_tiles(const fs::path& target) {
  std::error_code ignored;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(directory_of(target), ignored)) {
    if (is_temporary_of(entry.path().filename().string(), target.filename().string()))
      found.push_back(entry.path());
  }
  for (const fs::path& path : found) {
    const FileDescriptor held(
        ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC | O_NOFOLLOW));
    if (held.valid() && ::flock(held.get(), LOCK_EX | LOCK_NB) == 0) remove_tiles(path);
  }
}

void flush_directory(const fs::path& directory) {
  const FileDescriptor held(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  // Some file systems refuse; the files are whole all the same.
  if (held.valid()) ::fsync(held.get());
}

/// Both names change their meaning at once where the system can do that.
bool exchange(const fs::path& a, const fs::path& b) {
#ifdef RENAME_EXCHANGE
  return ::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0;
#else
  return false;
#endif
}

}  // namespace

fs::path tile_directory_of(const fs::path& mesh) {
  fs::path stem = mesh;
  if (stem.extension() == ".gz") stem.replace_extension();
  return stem.replace_extension(".tiles");
}

std::string tile_name(const fs::path& mesh, std::uint32_t number) {
  char text[16];
  std::snprintf(text, sizeof text, "%06u", number);
  return text + std::string(mesh.extension() == ".gz" ? ".ply.gz" : ".ply");
}

void check_tile_directory(const fs::path& directory) {
  std::error_code absent;
  const auto status = fs::symlink_status(directory, absent);
  if (!fs::exists(status)) return;
  std::string found = "no directory";
  if (fs::is_directory(status)) {
    std::error_code error;
    const auto all = fs::directory_iterator(directory, error);
    if (error) fail(directory, error);
    const auto foreign =
        std::find_if(begin(all), end(all), [](const auto& entry) { return !is_ours(entry); });
    if (foreign == end(all)) return;
    found = foreign->path().filename().string();
  }
  throw_usage("the tiles would replace what is there",
              {.file = directory.string(),
               .place = {},
               .found = found,
               .expected = "nothing, or the tiles of an earlier run",
               .advice = "Move it away or name another mesh"});
}

TileDirectory::TileDirectory(fs::path target) : target_(std::move(target)) {
  remove_abandoned_tiles(target_);
  temporary_ = temporary_beside(target_);
  do {
    if (::mkdir(temporary_.c_str(), 0777) != 0 && errno != EEXIST) fail_of_system(target_);
    lock_ = FileDescriptor(::open(temporary_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!lock_.valid() && errno != ENOENT) fail_of_system(target_);
  } while (!lock_.valid() || !keep_temporary(lock_.get()));
}

TileDirectory::~TileDirectory() {
  if (!temporary_.empty()) remove_tiles(temporary_);
}

void TileDirectory::commit() {
  ::fsync(lock_.get());  // some file systems refuse; the files are whole all the same
  std::error_code absent;
  if (!fs::exists(target_, absent)) {
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail_of_system(target_);
    temporary_.clear();
  } else {
    check_tile_directory(target_);
    if (!exchange(temporary_, target_)) {
      remove_tiles(target_);
      if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail_of_system(target_);
      temporary_.clear();
    }
  }
  flush_directory(directory_of(target_));
  if (!temporary_.empty()) remove_tiles(std::exchange(temporary_, fs::path()));  // the old ones
}

}  // namespace orbweave
