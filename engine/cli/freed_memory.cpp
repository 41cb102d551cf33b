#include "engine/cli/freed_memory.h"

#include <malloc.h>

#include <algorithm>

namespace orbweave {

void keep_freed_memory(std::uint64_t budget_bytes, int threads) {
#ifdef __GLIBC__
  // The heap that glibc gives a thread has 64 MiB, which stay with the thread. 32 MiB are the most
  // that it allows for blocks that come from a heap.
  constexpr std::uint64_t kHeapBytes = std::uint64_t{64} << 20;
  constexpr std::uint64_t kBlockBytes = std::uint64_t{32} << 20;
  constexpr std::uint64_t kMostBytes = std::uint64_t{256} << 20;
  const std::uint64_t share = budget_bytes / 16;
  if (budget_bytes / 8 < kHeapBytes * static_cast<std::uint64_t>(threads + 1)) return;
  ::mallopt(M_TRIM_THRESHOLD, static_cast<int>(std::min(share, kMostBytes)));
  ::mallopt(M_MMAP_THRESHOLD, static_cast<int>(std::min(share, kBlockBytes)));
#else
  static_cast<void>(budget_bytes);
  static_cast<void>(threads);
#endif
}

}  // namespace orbweave
