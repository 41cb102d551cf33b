// A file that many threads, and many processes, write at once, every byte at its place.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "io/system/file_descriptor.h"

namespace orbweave {

/// Bytes on their way to a place of a file. They lie in memory as they will lie on the device's
/// pages, so that they need not be copied once more on the way.
class PlacedBuffer {
 public:
  /// Room for `bytes` bytes at `offset` of the file, uninitialised. Memory is kept and used again.
  std::byte* place(std::uint64_t offset, std::size_t bytes);
  std::uint64_t offset() const { return offset_; }
  std::span<const std::byte> bytes() const { return {data_, bytes_}; }

 private:
  struct Free {
    void operator()(std::byte* memory) const;
  };
  std::unique_ptr<std::byte, Free> memory_;
  std::size_t capacity_ = 0;
  std::byte* data_ = nullptr;
  std::size_t bytes_ = 0;
  std::uint64_t offset_ = 0;
};

/// Opens a file that is there and writes to it. Whole pages go past the page cache where the file
/// system can do that: copying into fresh pages costs more than everything else about a large
/// file. All methods are thread-safe and throw Error (resource) that names `name` and the
/// system's reason.
class PlacedFile {
 public:
  /// `name`: what the user knows the file as.
  PlacedFile(const std::filesystem::path& path, std::filesystem::path name);
  /// Room for the whole file, so that a full disk shows before the work.
  void reserve(std::uint64_t bytes);
  void write(const PlacedBuffer& buffer);
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Returns when all that this process wrote is on the device.
  void flush();

 private:
  void write_to(int file, std::uint64_t offset, std::span<const std::byte> bytes);
  bool write_direct(std::uint64_t offset, std::span<const std::byte> bytes);
  [[noreturn]] void fail(const char* problem) const;

  std::filesystem::path name_;
  FileDescriptor file_;
  FileDescriptor direct_;
  std::atomic<bool> can_direct_{false};
};

/// Writes on threads of its own: the computing ones do not wait for the device.
class WriteBehind {
 public:
  /// `buffers`: how many there are; at least one more than are taken at a time.
  WriteBehind(PlacedFile& file, std::size_t buffers);
  /// Drops what has not been written yet.
  ~WriteBehind();
  WriteBehind(const WriteBehind&) = delete;
  WriteBehind& operator=(const WriteBehind&) = delete;

  /// A free buffer; waits for one. Rethrows what writing threw. Thread-safe.
  std::unique_ptr<PlacedBuffer> take();
  /// Thread-safe.
  void give(std::unique_ptr<PlacedBuffer> buffer);
  /// Returns when everything given is written; rethrows what writing threw.
  void finish();

 private:
  explicit WriteBehind(PlacedFile& file) : file_(file) {}
  void run();

  PlacedFile& file_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::unique_ptr<PlacedBuffer>> free_;
  std::deque<std::unique_ptr<PlacedBuffer>> given_;
  std::size_t writing_ = 0;
  bool ending_ = false;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace orbweave
