// Resident memory of this process: now, and the most while something was watched.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>

namespace orbweave {

/// Resident memory of this process, bytes; 0 where the system does not say. Takes microseconds.
std::uint64_t resident_bytes();

/// Gives memory that was freed back to the system, as far as the allocator can; resident_bytes()
/// falls by what it kept for later. Takes milliseconds per gigabyte held.
void release_freed_memory();

/// The same where the process holds a tenth of its budget or more, else nothing. Freed memory does
/// no harm below that, and a small job takes several percent longer when the system has to hand it
/// out again.
void release_freed_memory(std::uint64_t budget_bytes);

/// Samples resident memory from its construction to its end, every few milliseconds, on a thread
/// of its own. What is larger for a shorter time may go unseen.
class MemoryWatch {
 public:
  MemoryWatch();
  ~MemoryWatch();
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

  /// The most so far, this moment included.
  std::uint64_t peak_bytes();

 private:
  void sample();
  void run();

  std::atomic<std::uint64_t> peak_{0};
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace orbweave
