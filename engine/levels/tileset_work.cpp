#include "engine/levels/tileset_work.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <cerrno>
#include <exception>
#include <string>
#include <system_error>
#include <utility>

#include "io/error.h"
#include "io/system/system_advice.h"

namespace orbweave {
namespace {

constexpr const char* kStore = "tileset";

[[noreturn]] void throw_unmade(const std::filesystem::path& directory, int error) {
  throw_resource(
      "cannot make the work directory",
      {.file = directory.string(), .found = system_reason(error), .advice = advice_on(error)});
}

/// Whether the directory that is open still has its name: a process that ends removes its own.
bool has_name(const FileDescriptor& open, const std::filesystem::path& directory) {
  struct stat held = {}, named = {};
  return ::fstat(open.get(), &held) == 0 && ::stat(directory.c_str(), &named) == 0 &&
         held.st_ino == named.st_ino && held.st_dev == named.st_dev;
}

/// Makes the directory where it is absent, and locks it as long as the process has it open.
FileDescriptor hold(const std::filesystem::path& directory) {
  // Another process may remove its own directory between two of these steps, again and again; a
  // file system that gives an open directory another number than its name has would never agree.
  constexpr int kMostTries = 100;
  for (int tries = 1;; ++tries) {
    std::error_code error;
    std::filesystem::create_directory(directory, error);
    if (error) throw_unmade(directory, error.value());
    FileDescriptor held(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!held.valid() && errno == ENOENT && tries < kMostTries) continue;
    if (!held.valid()) throw_unmade(directory, errno);
    // A file system without locks guards nothing.
    if (::flock(held.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
      throw_resource("the work directory is in use by another process",
                     {.file = directory.string(),
                      .advice = "Wait for that one to end, or write to another place"});
    if (has_name(held, directory) || tries >= kMostTries) return held;
  }
}

}  // namespace

TilesetWork::TilesetWork(std::filesystem::path directory)
    : directory_(std::move(directory)), held_(hold(directory_)) {
  record_ = std::make_shared<OwnedFiles>(directory_, kStore, 0);
  record_->remove_abandoned();
  scope_.emplace(record_);
}

TilesetWork::~TilesetWork() {
  scope_.reset();
  try {
    record_->close();
    record_->remove_record(directory_ / (std::string(kRecordName) + "0"));
    remove_if_empty(directory_);
  } catch (const std::exception&) {
    // What stays is found by the next run.
  }
}

}  // namespace orbweave
