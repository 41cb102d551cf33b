// A file without a name for what does not fit into memory.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "io/system/file_descriptor.h"

namespace orbweave {

/// Bytes on disk that go with the object, however the process ends. Thread-safe. Failures are an
/// Error (resource) with the directory and the system's reason.
class SpoolFile {
 public:
  explicit SpoolFile(std::filesystem::path directory);

  /// Returns where the bytes begin.
  std::uint64_t append(std::span<const std::byte> bytes);
  /// Fills `out` with what lies from byte `offset` on, which must have been written.
  void read(std::uint64_t offset, std::span<std::byte> out) const;
  std::uint64_t bytes() const { return bytes_; }

  template <class T>
  std::uint64_t append_values(std::span<const T> values) {
    return append(std::as_bytes(values));
  }
  template <class T>
  void read_values(std::uint64_t offset, std::span<T> out) const {
    read(offset, std::as_writable_bytes(out));
  }

 private:
  [[noreturn]] void fail(const char* problem, int error) const;

  std::filesystem::path directory_;
  FileDescriptor file_;
  std::atomic<std::uint64_t> bytes_{0};
};

}  // namespace orbweave
