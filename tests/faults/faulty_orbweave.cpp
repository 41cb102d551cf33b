// The program with one fault of the file system. The environment says which:
//
//   ORBWEAVE_FAULT=KIND:NUMBER:EFFECT   the call of that kind and number (from 1) fails
//   ORBWEAVE_FAULT_COUNTS=FILE          gets one line "KIND calls" per kind at the end, and
//                                       "injected 1" where the fault was reached
//
// Kinds: write (write, pwrite, pwritev, ftruncate, fallocate), sync (fsync, fdatasync, syncfs),
// rename, read (read and pread of files in the current directory). Effects: short (half of the
// bytes are written and the call says so), full (half of the bytes are written, then ENOSPC from
// here on), eio (nothing is done), torn (a rename that is done to half a file and reports EIO, as
// after a power cut on a file system without a journal). The program's own calls that write pass
// io/system/file_calls.h; HDF5's pass the pwrite() defined here, and all calls that read pass the
// read() and pread() defined here.
#include <sys/stat.h>
#include <sys/syscall.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "engine/cli/command_line.h"
#include "engine/cli/exit_status.h"
#include "engine/cli/failure.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/system/file_calls.h"
#include "io/system/hdf5_exit.h"

namespace {

orbweave::StopToken stop;
ORBWEAVE_END_PLAINLY_FROM_THE_START;

enum Kind : std::size_t { kWrite, kSync, kRename, kRead, kKinds };
constexpr std::array<const char*, kKinds> kNames = {"write", "sync", "rename", "read"};

struct Fault {
  Kind kind = kKinds;
  std::uint64_t number = 0;
  std::string effect;
};
Fault fault;
std::array<std::atomic<std::uint64_t>, kKinds> calls;
std::atomic<bool> injected{false};
std::atomic<bool> disk_is_full{false};

/// Counts a call; true where it is the one that fails.
bool fails(Kind kind) {
  const std::uint64_t number = ++calls[kind];
  if (kind != fault.kind || number != fault.number) return false;
  injected = true;
  if (fault.effect == "full") disk_is_full = true;
  return true;
}

/// Writes with `write(bytes)`, unless this is the call that fails.
template <class Write>
ssize_t faulty_write(std::size_t bytes, const Write& write) {
  const bool was_full = disk_is_full;
  const bool failing = fails(kWrite);
  if (was_full || (failing && fault.effect == "eio")) {
    errno = was_full ? ENOSPC : EIO;
    return -1;
  }
  if (!failing) return write(bytes);
  const ssize_t half = write(std::max<std::size_t>(bytes / 2, 1));
  if (fault.effect == "short" || (half > 0 && bytes > 1)) return half;
  errno = ENOSPC;
  return -1;
}

ssize_t plain_pwrite(int file, const void* data, std::size_t bytes, off_t offset) {
  return ::syscall(SYS_pwrite64, file, data, bytes, offset);
}

ssize_t faulty_plain_write(int file, const void* data, std::size_t bytes) {
  return faulty_write(bytes, [&](std::size_t count) { return ::write(file, data, count); });
}

ssize_t faulty_pwritev(int file, const iovec* pieces, int count, off_t offset) {
  std::size_t bytes = 0;
  for (int i = 0; i < count; ++i) bytes += pieces[i].iov_len;
  return faulty_write(bytes, [&](std::size_t wanted) -> ssize_t {
    if (wanted == bytes) return ::pwritev(file, pieces, count, offset);
    return plain_pwrite(file, pieces[0].iov_base, std::min(wanted, pieces[0].iov_len), offset);
  });
}

/// Calls `call` unless it fails: with `error`, or since the disk is full.
template <class Call>
int faulty(Kind kind, int error, const Call& call) {
  const bool was_full = kind == kWrite && disk_is_full;
  if (!fails(kind) && !was_full) return call();
  errno = was_full ? ENOSPC : error;
  return -1;
}

/// Whether this is the read that fails. Files elsewhere, pipes and devices are not counted.
bool reading_fails(int file) {
  std::array<char, 4096> name{};
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  static const std::string here = std::filesystem::current_path().string() + "/";
  const ssize_t length = ::readlink(link.c_str(), name.data(), name.size());
  const bool is_here =
      std::string_view(name.data(), std::max<ssize_t>(length, 0)).starts_with(here);
  return is_here && fails(kRead);
}

int error_of_writes() { return fault.effect == "eio" ? EIO : ENOSPC; }

int faulty_ftruncate(int file, off_t bytes) {
  return faulty(kWrite, error_of_writes(), [&] { return ::ftruncate(file, bytes); });
}
int faulty_fallocate(int file, int mode, off_t offset, off_t bytes) {
  return faulty(kWrite, error_of_writes(), [&] { return ::fallocate(file, mode, offset, bytes); });
}
int faulty_fsync(int file) {
  return faulty(kSync, EIO, [&] { return ::fsync(file); });
}
int faulty_fdatasync(int file) {
  return faulty(kSync, EIO, [&] { return ::fdatasync(file); });
}
int faulty_syncfs(int file) {
  return faulty(kSync, EIO, [&] { return ::syncfs(file); });
}
int faulty_rename(const char* from, const char* to) {
  return faulty(kRename, EIO, [&] { return ::rename(from, to); }) == 0 ? 0 : [&] {
    struct stat facts {};
    if (fault.effect == "torn" && ::rename(from, to) == 0 && ::stat(to, &facts) == 0 &&
        S_ISREG(facts.st_mode) && ::truncate(to, facts.st_size / 2) != 0)
      std::abort();
    errno = EIO;
    return -1;
  }();
}

/// "KIND:NUMBER:EFFECT"; ends the program where it says something else.
Fault parse_fault(const std::string& text) {
  const std::size_t first = text.find(':');
  const std::size_t second = text.find(':', first + 1);
  if (second == std::string::npos) std::abort();
  const auto name = std::find(kNames.begin(), kNames.end(), text.substr(0, first));
  if (name == kNames.end()) std::abort();
  return {static_cast<Kind>(name - kNames.begin()), std::stoull(text.substr(first + 1)),
          text.substr(second + 1)};
}

void write_counts() {
  const char* path = std::getenv("ORBWEAVE_FAULT_COUNTS");
  if (path == nullptr) return;
  std::ofstream file(path);
  for (std::size_t kind = 0; kind < kKinds; ++kind)
    file << kNames[kind] << " " << calls[kind] << "\n";
  file << "injected " << injected << "\n";
}

int run(int argc, char** argv) {
  try {
    orbweave::close_hdf5_at_exit();
    orbweave::handle_signals(stop);
    orbweave::parse_command_line({argv, argv + argc}, stop)();
    orbweave::flush_output();
    return static_cast<int>(orbweave::ExitStatus::kDone);
  } catch (...) {
    const orbweave::Failure failure = orbweave::current_failure();
    orbweave::print_error(failure.what);
    return static_cast<int>(orbweave::exit_status(failure.kind));
  }
}

}  // namespace

// Libraries find these in place of the C library's.
extern "C" ssize_t pwrite(int file, const void* data, std::size_t bytes, off_t offset) {
  return faulty_write(bytes,
                      [&](std::size_t count) { return plain_pwrite(file, data, count, offset); });
}
extern "C" ssize_t read(int file, void* data, std::size_t bytes) {
  if (!reading_fails(file)) return ::syscall(SYS_read, file, data, bytes);
  errno = EIO;
  return -1;
}
extern "C" ssize_t pread(int file, void* data, std::size_t bytes, off_t offset) {
  if (!reading_fails(file)) return ::syscall(SYS_pread64, file, data, bytes, offset);
  errno = EIO;
  return -1;
}

int main(int argc, char** argv) {
  if (const char* text = std::getenv("ORBWEAVE_FAULT")) fault = parse_fault(text);
  orbweave::file_calls = {.write = faulty_plain_write,
                          .pwrite = ::pwrite,
                          .pwritev = faulty_pwritev,
                          .ftruncate = faulty_ftruncate,
                          .fsync = faulty_fsync,
                          .fdatasync = faulty_fdatasync,
                          .fallocate = faulty_fallocate,
                          .syncfs = faulty_syncfs,
                          .rename = faulty_rename};
  const char* unflushed = std::getenv("ORBWEAVE_TIME_UNFLUSHED");
  orbweave::time_unflushed = std::chrono::seconds(unflushed != nullptr ? std::stoi(unflushed) : 0);
  const int status = run(argc, argv);
  write_counts();
  return status;
}
