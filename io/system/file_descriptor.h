// An owned file descriptor, and what all readers check when they open a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "io/error.h"

namespace orbweave {

/// Owns a POSIX file descriptor.
class FileDescriptor {
 public:
  explicit FileDescriptor(int descriptor = -1) : descriptor_(descriptor) {}
  ~FileDescriptor();
  FileDescriptor(FileDescriptor&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  int get() const { return descriptor_; }
  bool valid() const { return descriptor_ >= 0; }
  /// Gives it away.
  int release() { return std::exchange(descriptor_, -1); }

 private:
  int descriptor_;
};

/// Fills `out` with what lies from byte `offset` on, however often the system interrupts. Returns
/// the number of bytes, fewer only where the file ends; nothing where it cannot be read: errno says
/// why.
std::optional<std::size_t> read_at(int descriptor, std::uint64_t offset, std::span<std::byte> out);
/// Writes all of `bytes` from byte `offset` on. False where the system refuses: errno says why,
/// ENOSPC where it takes nothing more without a reason.
bool write_at(int descriptor, std::uint64_t offset, std::span<const std::byte> bytes);
/// What errno means, whatever the locale.
std::string system_reason(int error);
/// Throws Error for a file that cannot be opened or read, with the reason `error`, a value of
/// errno. Resource where a device, a network or a limit is in the way, so that the same command may
/// read the file later; else bad input.
[[noreturn]] void throw_unread(const std::string& problem, ErrorParts parts, int error);
/// Whether the file gives its bytes once: standard input ("-"), a pipe, a terminal. Opens nothing.
bool is_read_once(const std::string& name);
/// Throws Error for such a file, to be called by what reads a file several times: wrong usage for
/// standard input, else bad input.
void require_rereadable(const std::string& name);
/// The same for such a file that is named twice.
void require_once_each(std::span<const std::string> names);
/// What opening the file would throw, without a read: a pipe loses nothing by it.
void check_readable(const std::string& name);
/// Opens for reading. Throws Error (bad input, or resource as throw_unread()).
int open_or_throw(const std::string& name);
/// The size of a regular file, nothing for a pipe or a device. Throws Error (bad input) for what
/// cannot be a scan: a directory, an empty file.
std::optional<std::uint64_t> checked_size(int descriptor, const std::string& name);
bool starts_like_gzip(int descriptor);

}  // namespace orbweave
