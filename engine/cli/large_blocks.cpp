// Large pages for large blocks: a pass over millions of points asks for arrays of many megabytes,
// and on pages of 4 KiB the kernel takes up to a fifth of the processor time to hand them out, in
// virtual machines above all. What replaces operator new belongs to a program, never to a library:
// only the executables compile this file. The sanitizers bring an operator new of their own.
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ORBWEAVE_INSTRUMENTED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define ORBWEAVE_INSTRUMENTED
#endif
#endif

#if defined(__linux__) && !defined(ORBWEAVE_INSTRUMENTED)
#include <sys/mman.h>

namespace {

constexpr std::size_t kLargeBlockBytes = std::size_t{1} << 20;
constexpr std::uintptr_t kLargePageBytes = std::uintptr_t{2} << 20;

/// Asks for large pages where they lie within the block, so that the process never holds more than
/// the blocks it asked for. The kernel may decline; nothing but the time depends on it. Errors stay
/// those of the calls before: a block is also asked for while one of them is being described.
void ask_for_large_pages(void* block, std::size_t bytes) noexcept {
  const auto address = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t first = (address + kLargePageBytes - 1) & ~(kLargePageBytes - 1);
  const std::uintptr_t last = (address + bytes) & ~(kLargePageBytes - 1);
  if (first >= last) return;
  const int error = errno;
  ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
  errno = error;
}

}  // namespace

void* operator new(std::size_t bytes) {
  while (true) {
    if (void* const block = std::malloc(bytes == 0 ? 1 : bytes)) {
      if (bytes >= kLargeBlockBytes) ask_for_large_pages(block, bytes);
      return block;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
#endif
