#include "io/system/memory_watch.h"

#include <fcntl.h>
#include <malloc.h>
#include <unistd.h>

#include <array>
#include <charconv>
#include <chrono>
#include <string_view>

namespace orbweave {
namespace {

constexpr std::chrono::milliseconds kInterval{20};

/// The second word of /proc/self/statm: resident pages.
std::uint64_t resident_pages(std::string_view text) {
  const std::size_t space = text.find(' ');
  if (space == std::string_view::npos) return 0;
  text.remove_prefix(space + 1);
  std::uint64_t pages = 0;
  std::from_chars(text.data(), text.data() + text.size(), pages);
  return pages;
}

}  // namespace

std::uint64_t resident_bytes() {
  const int file = ::open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
  if (file < 0) return 0;
  std::array<char, 128> text{};
  const ssize_t length = ::read(file, text.data(), text.size());
  ::close(file);
  if (length <= 0) return 0;
  return resident_pages({text.data(), static_cast<std::size_t>(length)}) *
         static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void release_freed_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

void release_freed_memory(std::uint64_t budget_bytes) {
  constexpr std::uint64_t kSpared = 10;  // parts of the budget
  if (resident_bytes() >= budget_bytes / kSpared) release_freed_memory();
}

MemoryWatch::MemoryWatch() {
  sample();
  thread_ = std::thread([this] { run(); });
}

MemoryWatch::~MemoryWatch() {
  {
    const std::scoped_lock lock(mutex_);
    ended_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

std::uint64_t MemoryWatch::peak_bytes() {
  sample();
  return peak_.load();
}

void MemoryWatch::sample() {
  const std::uint64_t now = resident_bytes();
  std::uint64_t before = peak_.load();
  while (before < now && !peak_.compare_exchange_weak(before, now)) {
  }
}

void MemoryWatch::run() {
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, kInterval, [this] { return ended_; })) sample();
}

}  // namespace orbweave
