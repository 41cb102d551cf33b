// How tasks are dealt out to a team: every task once, few calls of the counter, short work at the
// end.
#include "partition/task_shares.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
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

/// What processes take that ask the counter in turns, each knowing what was left after its own last
/// call.
std::vector<TaskRange> blocks_of_calls(const TaskShares& shares, int processes, double wanted) {
  std::vector<TaskRange> blocks;
  std::vector<std::size_t> seen(static_cast<std::size_t>(processes), shares.first_counted());
  std::vector<std::uint64_t> latest(seen.size(), 0);
  std::size_t next = shares.first_counted();
  while (next < shares.tasks())
    for (std::size_t rank = 0; rank < seen.size(); ++rank) {
      const std::size_t count = shares.of_call(seen[rank], wanted, latest[rank]);
      const std::size_t end = std::min(next + count, shares.tasks());
      if (next < end) blocks.push_back({next, end});
      latest[rank] = shares.length({next, end});
      next = seen[rank] = end;
    }
  return blocks;
}

}  // namespace

TEST_CASE("EveryTaskIsDealtOutOnce") {
  const std::size_t tasks = GENERATE(0, 1, 2, 7, 64, 1000, 7400);
  const int processes = GENERATE(1, 2, 3, 64, 1000);
  const int threads = GENERATE(0, 1, 16);
  for (const Lengths& lengths : {Lengths(tasks, 1), Lengths(tasks, 0), spread_lengths(tasks)}) {
    const TaskShares shares(lengths, processes, threads);
    INFO(tasks << " tasks, " << processes << " processes, " << threads << " threads");
    std::size_t next = 0;
    for (int rank = 0; rank < processes; ++rank) {
      CHECK(shares.by_number(rank).begin == next);
      CHECK(shares.by_number(rank).end >= next);
      next = shares.by_number(rank).end;
    }
    CHECK(shares.first_counted() == next);
    for (const TaskRange& block : blocks_of_calls(shares, processes, 0.0)) {
      CHECK(block.begin == next);
      next = block.end;
    }
    CHECK(next == tasks);
  }
}

TEST_CASE("TheCounterIsAskedRarely") {
  const auto calls = [](int processes, double wanted) {
    return blocks_of_calls(TaskShares(Lengths(7400, 1), processes, 16), processes, wanted).size();
  };
  // tests/bench/cluster_model_test.py has the same.
  CHECK(calls(2, 0.0) == 32);
  CHECK(calls(64, 0.0) == 668);
  CHECK(calls(100, 0.0) < 1000);
  // Where all tasks start at once, nobody asks.
  CHECK(calls(1000, 0.0) == 0);
  // Tasks that are soon done are dealt out by one call of each process, and one of the last.
  CHECK(calls(64, 1e9) == 65);
}

TEST_CASE("BlocksShrinkToOneTask") {
  const int processes = GENERATE(2, 8, 64);
  const TaskShares shares(Lengths(7400, 5), processes, 4);
  const std::vector<TaskRange> blocks = blocks_of_calls(shares, processes, 0.0);
  const auto size = [&](std::size_t i) { return blocks[i].end - blocks[i].begin; };
  const auto team = static_cast<std::size_t>(processes);
  CHECK(size(0) <= shares.by_number(0).end);
  // None is longer than the others need for the rest.
  for (std::size_t i = 0; i < blocks.size(); ++i)
    CHECK((size(i) - 1) * team <= 7400 - blocks[i].begin);
  // Every process ends with a single task.
  for (std::size_t last = 1; last <= team; ++last) CHECK(size(blocks.size() - last) == 1);
}

TEST_CASE("AShareIsOfTheLengthAndNotOfTheNumber") {
  // Half of the work lies in ten tasks, which two processes have to share.
  Lengths lengths(10, 1000);
  lengths.resize(1010, 10);
  const TaskShares shares(lengths, 2, 1);
  CHECK(shares.by_number(0).end == 5);
  CHECK(shares.by_number(1).end == 10);
  const Lengths spread = spread_lengths(5000);
  const TaskShares cut(spread, 4, 1);
  const std::uint64_t all = cut.length({0, cut.tasks()});
  for (int rank = 0; rank < 4; ++rank)
    CHECK(cut.length(cut.by_number(rank)) <= all / 8 + spread[cut.by_number(rank).begin]);
  for (const double wanted : {0.0, static_cast<double>(all)})
    for (const std::size_t first : {cut.first_counted(), std::size_t{4000}, std::size_t{4999}}) {
      const std::size_t count = cut.of_call(first, wanted, 0);
      CHECK(cut.length({first, first + count}) <=
            std::max(cut.length({first, cut.tasks()}) / (wanted > 0.0 ? 4 : 8), spread[first]));
    }
}

TEST_CASE("ABlockLastsUntilTheCounterHasServedAllTwice") {
  // 100 units of length a second; 64 calls of 5 milliseconds, twice.
  CHECK(length_worth_a_call(1000, 10.0, 64, 0.005) == Approx(64.0));
  CHECK(length_worth_a_call(1000, 0.0, 64, 0.005) == 0.0);
  CHECK(length_worth_a_call(1000, 10.0, 64, 0.0) == 0.0);
}

}  // namespace orbweave
