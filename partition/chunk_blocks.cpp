#include "partition/chunk_blocks.h"

#include <algorithm>

namespace orbweave {
namespace {

/// A block is one of so many shares of a process in what is left: one that is half as fast as the
/// others ends its first block when all are done.
constexpr std::uint64_t kShares = 2;

std::uint64_t length_of(std::uint64_t length) { return std::max<std::uint64_t>(length, 1); }

/// End of a block that begins at `first` and has 1 / `shares` of `left`, rounded to whole tasks.
std::size_t end_of_block(std::span<const std::uint64_t> lengths, std::size_t first,
                         std::uint64_t left, std::uint64_t shares) {
  std::size_t end = first;
  for (std::uint64_t taken = 0; end < lengths.size(); ++end) {
    const std::uint64_t next = length_of(lengths[end]);
    if (end > first && (2 * taken + next) * shares > 2 * left) break;
    taken += next;
  }
  return end;
}

}  // namespace

std::vector<std::size_t> cut_blocks(std::span<const std::uint64_t> lengths, int processes,
                                    int threads) {
  const auto team = static_cast<std::size_t>(std::max(processes, 1));
  const auto at_once = static_cast<std::size_t>(std::max(threads, 1));
  const std::size_t least_of_first = std::min(at_once, (lengths.size() + team - 1) / team);
  std::uint64_t left = 0;
  for (const std::uint64_t length : lengths) left += length_of(length);
  std::vector<std::size_t> begins = {0};
  while (begins.back() < lengths.size()) {
    const std::size_t first = begins.back();
    const std::size_t least = begins.size() <= team ? first + least_of_first : first + 1;
    const std::size_t end = end_of_block(lengths, first, left, kShares * team);
    begins.push_back(std::min(std::max(least, end), lengths.size()));
    for (std::size_t task = first; task < begins.back(); ++task) left -= length_of(lengths[task]);
  }
  return begins;
}

}  // namespace orbweave
