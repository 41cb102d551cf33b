// Blocks of chunks that a team takes from its counter: every chunk once, few blocks, short work at
// the end.
#include "partition/chunk_blocks.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numeric>

#include "tests/support/clouds.h"

namespace orbweave {
namespace {

using Lengths = std::vector<std::uint64_t>;

/// As stages have them: within a factor of two the order is that of the chunks.
Lengths spread_lengths(std::size_t count) {
  test::Random random(count + 1);
  Lengths lengths(count);
  for (std::uint64_t& length : lengths) length = 1000 + random.below(100'000);
  std::stable_sort(lengths.begin(), lengths.end(), [](std::uint64_t a, std::uint64_t b) {
    return std::bit_width(a) > std::bit_width(b);
  });
  return lengths;
}

std::uint64_t length_of(const Lengths& lengths, std::size_t first, std::size_t last) {
  return std::accumulate(lengths.begin() + static_cast<std::ptrdiff_t>(first),
                         lengths.begin() + static_cast<std::ptrdiff_t>(last), std::uint64_t{0});
}

}  // namespace

TEST_CASE("BlocksHoldEveryTaskOnce") {
  const std::size_t tasks = GENERATE(0, 1, 2, 7, 64, 1000, 7400);
  const int processes = GENERATE(1, 2, 3, 64, 1000);
  const int threads = GENERATE(0, 1, 16);
  for (const Lengths& lengths : {Lengths(tasks, 1), Lengths(tasks, 0), spread_lengths(tasks)}) {
    const std::vector<std::size_t> blocks = cut_blocks(lengths, processes, threads);
    INFO(tasks << " tasks, " << processes << " processes, " << threads << " threads");
    CHECK(blocks.front() == 0);
    CHECK(blocks.back() == tasks);
    CHECK(std::is_sorted(blocks.begin(), blocks.end(), std::less_equal<>()));
  }
}

TEST_CASE("BlocksAreFew") {
  const auto count = [](int processes, int threads) {
    return cut_blocks(Lengths(7400, 1), processes, threads).size() - 1;
  };
  // tests/bench/cluster_model_test.py has the same.
  CHECK(count(2, 16) == 30);
  CHECK(count(64, 16) == 654);
  CHECK(count(100, 16) < 1000);
  // Where all tasks start at once, a process asks once.
  CHECK(count(1000, 16) == 925);
  for (const int processes : {2, 8, 64}) {
    const Lengths lengths = spread_lengths(7400);
    const auto least = static_cast<double>(*std::min_element(lengths.begin(), lengths.end()));
    const auto all = static_cast<double>(length_of(lengths, 0, lengths.size()));
    const double shares = 2.0 * processes;
    const double bound = 1.1 * shares * (1.0 + std::log(all / (shares * least)));
    CHECK(static_cast<double>(cut_blocks(lengths, processes, 4).size() - 1) < bound);
  }
}

TEST_CASE("BlocksShrinkToOneTask") {
  const int processes = GENERATE(2, 8, 64);
  const std::vector<std::size_t> blocks = cut_blocks(Lengths(7400, 5), processes, 4);
  std::size_t before = 7400;
  for (std::size_t block = 0; block + 1 < blocks.size(); ++block) {
    const std::size_t size = blocks[block + 1] - blocks[block];
    CHECK(size <= before);
    before = size;
  }
  // Every process ends with a single task.
  for (int last = 1; last <= processes; ++last)
    CHECK(*(blocks.end() - last) - *(blocks.end() - last - 1) == 1);
}

TEST_CASE("ABlockHasItsPartOfTheLengthAndNotOfTheNumber") {
  // Half of the work lies in ten tasks, which two processes have to share.
  Lengths lengths(10, 1000);
  lengths.resize(1010, 10);
  const std::vector<std::size_t> blocks = cut_blocks(lengths, 2, 1);
  CHECK(blocks[1] == 5);
  const Lengths spread = spread_lengths(5000);
  const std::vector<std::size_t> cut = cut_blocks(spread, 4, 1);
  const std::uint64_t all = length_of(spread, 0, spread.size());
  for (std::size_t block = 0; block + 1 < cut.size(); ++block) {
    const std::uint64_t left = all - length_of(spread, 0, cut[block]);
    const std::uint64_t own = length_of(spread, cut[block], cut[block + 1]);
    CHECK(own <= left / 8 + spread[cut[block]]);
  }
}

}  // namespace orbweave
