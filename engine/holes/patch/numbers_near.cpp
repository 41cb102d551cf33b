#include "engine/holes/patch/numbers_near.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace orbweave {
namespace {

constexpr std::uint32_t kGroup = 32, kBlock = 512 * kGroup;

}  // namespace

std::vector<std::uint32_t> numbers_near(std::uint32_t count, const BoxTree& places,
                                        const std::function<Box(std::uint32_t)>& box_of) {
  std::vector<std::vector<std::uint32_t>> blocks((std::size_t{count} + kBlock - 1) / kBlock);
  const auto look_at_group = [&](std::uint32_t begin, std::vector<std::uint32_t>& out) {
    const std::uint32_t size = std::min(kGroup, count - begin);
    std::array<Box, kGroup> boxes;
    Box all;
    for (std::uint32_t i = 0; i < size; ++i) all.extend(boxes[i] = box_of(begin + i));
    if (!places.meets(all)) return;
    for (std::uint32_t i = 0; i < size; ++i)
      if (places.meets(boxes[i])) out.push_back(begin + i);
  };
  const auto look_at_block = [&](std::size_t block) {
    const auto begin = static_cast<std::uint32_t>(block * kBlock);
    const std::uint32_t size = std::min(kBlock, count - begin);
    for (std::uint32_t at = 0; at < size; at += kGroup) look_at_group(begin + at, blocks[block]);
  };
  // A thread that waits here must not begin another chunk, whose memory is not free yet.
  tbb::this_task_arena::isolate(
      [&] { tbb::parallel_for(std::size_t{0}, blocks.size(), look_at_block); });
  std::vector<std::uint32_t> numbers;
  for (const std::vector<std::uint32_t>& block : blocks)
    numbers.insert(numbers.end(), block.begin(), block.end());
  return numbers;
}

}  // namespace orbweave
