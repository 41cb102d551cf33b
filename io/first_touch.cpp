#include "io/first_touch.h"

#include <algorithm>
#include <cstdint>

#include "io/whole_loop.h"

namespace orbweave {
namespace {

constexpr std::uintptr_t kPageBytes = 4096;
/// A large page, which one thread takes.
constexpr std::uintptr_t kPieceBytes = std::uintptr_t{2} << 20;
/// Less is taken while a second thread wakes up.
constexpr std::size_t kLeastBytes = 2 * kPieceBytes;

}  // namespace

void touch_pages(void* block, std::size_t bytes) {
  if (bytes < kLeastBytes) return;
  auto* const begin = static_cast<volatile std::byte*>(block);
  const auto address = reinterpret_cast<std::uintptr_t>(block);
  const std::uintptr_t end = address + bytes;
  const auto touch = [&](std::uintptr_t piece) {
    const std::uintptr_t first = std::max(address, piece * kPieceBytes);
    const std::uintptr_t last = std::min(end, (piece + 1) * kPieceBytes);
    for (std::uintptr_t at = first; at < last; at = (at / kPageBytes + 1) * kPageBytes)
      begin[at - address] = std::byte{0};
  };
  const std::uintptr_t first_piece = address / kPieceBytes;
  for_each_whole((end + kPieceBytes - 1) / kPieceBytes - first_piece,
                 [&](std::size_t piece) { touch(first_piece + piece); });
}

}  // namespace orbweave
