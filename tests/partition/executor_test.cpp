// The executor keeps to threads and memory, and its failures are told once all is quiet.
#include "partition/executor.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

namespace orbweave {
namespace {

std::vector<ChunkTask> make_tasks(std::size_t count, std::size_t bytes) {
  std::vector<ChunkTask> tasks;
  for (std::size_t i = 0; i < count; ++i) tasks.push_back({static_cast<ChunkId>(i), bytes});
  return tasks;
}

/// Raises a maximum.
void raise_to(std::atomic<std::size_t>& most, std::size_t value) {
  std::size_t seen = most.load();
  while (seen < value && !most.compare_exchange_weak(seen, value)) {
  }
}

void nap(int microseconds = 200) {
  std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
}

/// What others do may take a while on a busy machine; false where it has not come in ten seconds.
template <class Condition>
bool await(const Condition& condition) {
  for (int i = 0; i < 10'000 && !condition(); ++i) nap(1000);
  return condition();
}

}  // namespace

TEST_CASE("EveryTaskRunsOnce") {
  const int threads = GENERATE(0, 1, 2, 5, 16);
  const std::size_t count = GENERATE(0, 1, 300);
  std::mutex mutex;
  std::multiset<ChunkId> seen;
  ExecutorOptions options;
  options.threads = threads;
  run_chunks(make_tasks(count, 10), options, [&](ChunkId chunk) {
    const std::scoped_lock lock(mutex);
    seen.insert(chunk);
  });
  REQUIRE(seen.size() == count);
  CHECK(std::set<ChunkId>(seen.begin(), seen.end()).size() == count);
}

TEST_CASE("MemoryInFlightKeepsToTheBudget") {
  const int threads = GENERATE(1, 2, 6);
  std::vector<ChunkTask> tasks;
  for (ChunkId i = 0; i < 200; ++i) tasks.push_back({i, 10 + 37 * (i % 11)});
  tasks[50].memory_bytes = 5000;  // larger than the budget: runs alone
  constexpr std::size_t kBudget = 700;
  std::atomic<std::size_t> in_flight{0}, running{0}, most{0}, most_running{0}, beside_large{0};
  ExecutorOptions options;
  options.threads = threads;
  options.memory_bytes = kBudget;
  run_chunks(tasks, options, [&](ChunkId chunk) {
    const std::size_t bytes = tasks[chunk].memory_bytes;
    const std::size_t now = in_flight += bytes;
    raise_to(most_running, ++running);
    if (chunk == 50)
      beside_large = now - bytes;
    else
      raise_to(most, now);
    nap();
    if (threads > 1 && chunk == 0) await([&] { return most_running > 1; });
    in_flight -= bytes;
    --running;
  });
  CHECK(most <= kBudget);
  CHECK(beside_large == 0);
  CHECK(most_running <= static_cast<std::size_t>(threads));
  if (threads > 1) CHECK(most_running > 1);
}

namespace {

/// One process of a team that takes its tasks one process after the other.
class CountedTeam final : public Communicator {
 public:
  CountedTeam(int rank, int size, std::atomic<std::uint64_t>& counter)
      : rank_(rank), size_(size), counter_(counter) {}
  int rank() const override { return rank_; }
  int size() const override { return size_; }

 protected:
  std::uint64_t count_up(std::uint64_t amount) override { return counter_.fetch_add(amount); }

 private:
  int rank_;
  int size_;
  std::atomic<std::uint64_t>& counter_;
};

}  // namespace

TEST_CASE("ATeamRunsEveryTaskOnceAndAsksTheCounterRarely") {
  constexpr int kTeam = 3;
  constexpr std::size_t kTasks = 3000;
  std::atomic<std::uint64_t> counter{0}, calls{0};
  std::mutex mutex;
  std::multiset<ChunkId> seen;
  std::vector<std::thread> processes;
  for (int rank = 0; rank < kTeam; ++rank) {
    processes.emplace_back([&, rank] {
      CountedTeam communicator(rank, kTeam, counter);
      ExecutorOptions options;
      options.threads = 2;
      options.threads_of_each = 2;
      options.communicator = &communicator;
      run_chunks(make_tasks(kTasks, 10), options, [&](ChunkId chunk) {
        const std::scoped_lock lock(mutex);
        seen.insert(chunk);
      });
      calls += communicator.counter_calls();
    });
  }
  for (std::thread& process : processes) process.join();
  CHECK(seen.size() == kTasks);
  CHECK(std::set<ChunkId>(seen.begin(), seen.end()).size() == kTasks);
  CHECK(calls < 60);
}

TEST_CASE("AProcessAloneDoesNotAskTheCounter") {
  std::atomic<std::uint64_t> counter{0};
  CountedTeam alone(0, 1, counter);
  std::atomic<std::size_t> done{0};
  ExecutorOptions options;
  options.threads = 2;
  options.communicator = &alone;
  run_chunks(make_tasks(100, 1), options, [&](ChunkId) { ++done; });
  CHECK(done == 100);
  CHECK(alone.counter_calls() == 0);
}

TEST_CASE("TasksStartInOrder") {
  ExecutorOptions options;
  options.threads = 1;
  std::vector<ChunkId> order;
  run_chunks(make_tasks(100, 1), options, [&](ChunkId chunk) { order.push_back(chunk); });
  CHECK(std::is_sorted(order.begin(), order.end()));
}

TEST_CASE("AnExceptionStopsTheRestAndIsRethrownWhenAllIsQuiet") {
  const int threads = GENERATE(1, 2, 4);
  ExecutorOptions options;
  options.threads = threads;
  std::atomic<int> running{0}, started{0};
  std::atomic<bool> thrown{false};
  const auto run = [&] {
    run_chunks(make_tasks(1000, 1), options, [&](ChunkId chunk) {
      ++running;
      ++started;
      nap();
      // Those beside it end when it has failed, and leave it time to tell.
      if (chunk > 20) await([&] { return thrown.load(); });
      if (chunk > 20) nap(20'000);
      --running;
      thrown = thrown || chunk == 20;
      if (chunk == 20) throw std::runtime_error("chunk 20");
    });
  };
  CHECK_THROWS_WITH(run(), "chunk 20");
  CHECK(running == 0);
  CHECK(started < 100);
}

TEST_CASE("AStopRequestInterruptsBetweenTasks") {
  const int threads = GENERATE(1, 3);
  StopToken stop;
  ExecutorOptions options;
  options.threads = threads;
  options.stop = &stop;
  std::atomic<int> started{0};
  const auto run = [&] {
    run_chunks(make_tasks(1000, 1), options, [&](ChunkId) {
      const int number = ++started;
      if (number == 10) stop.request();
      if (number > 10) await([&] { return stop.requested(); });
    });
  };
  try {
    run();
    FAIL("not interrupted");
  } catch (const Error& error) {
    CHECK(error.kind() == ErrorKind::kInterrupted);
  }
  CHECK(started >= 10);
  CHECK(started < 10 + threads);
}

TEST_CASE("WorkInsideATaskIsSharedAndNeverStartsAnotherTask") {
  const int threads = GENERATE(1, 2, 4);
  ExecutorOptions options;
  options.threads = threads;
  static thread_local int depth = 0;
  std::atomic<int> deepest{0};
  std::atomic<long> sum{0};
  run_chunks(make_tasks(50, 1), options, [&](ChunkId) {
    ++depth;
    if (depth > deepest) deepest = depth;
    for (int round = 0; round < 5; ++round)
      tbb::parallel_for(0, 200, [&](int i) {
        nap(i % 50 == 0 ? 50 : 0);
        sum += i;
      });
    --depth;
  });
  CHECK(sum == 50L * 5 * 199 * 100);
  CHECK(deepest == 1);
}

TEST_CASE("OneLargeTaskUsesAllThreads") {
  // As the program's main() does: the library asks TBB for no more threads than are allowed.
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 3);
  ExecutorOptions options;
  options.threads = 3;
  std::mutex mutex;
  std::set<std::thread::id> helpers;
  int arena_threads = 0;
  std::atomic<std::size_t> seen{0};
  run_chunks(make_tasks(1, 1), options, [&](ChunkId) {
    arena_threads = tbb::this_task_arena::max_concurrency();
    tbb::parallel_for(0, 300, [&](int i) {
      {
        const std::scoped_lock lock(mutex);
        helpers.insert(std::this_thread::get_id());
        seen = helpers.size();
      }
      if (i == 0) await([&] { return seen > 1; });
    });
  });
  CHECK(arena_threads == 3);
  CHECK(helpers.size() > 1);
  CHECK(helpers.size() <= 3);
}

TEST_CASE("AStageMayRunInsideAnother") {
  ExecutorOptions options;
  options.threads = 2;
  std::atomic<int> inner{0};
  run_chunks(make_tasks(6, 1), options,
             [&](ChunkId) { run_chunks(make_tasks(10, 1), options, [&](ChunkId) { ++inner; }); });
  CHECK(inner == 60);
}

TEST_CASE("NoChunkStartsBesideOthersWhileMemoryIsShort") {
  // The process holds more than was planned: whatever runs, runs alone, and all of it runs.
  std::atomic<int> running{0}, most_running{0}, done{0};
  ExecutorOptions options;
  options.threads = 4;
  options.process_bytes = 1000;
  options.resident = [] { return std::uint64_t{995}; };
  run_chunks(make_tasks(40, 10), options, [&](ChunkId) {
    const int now = ++running;
    int seen = most_running.load();
    while (seen < now && !most_running.compare_exchange_weak(seen, now)) {
    }
    nap();
    --running;
    ++done;
  });
  CHECK(most_running == 1);
  CHECK(done == 40);
}

TEST_CASE("ChunksThatHoldMoreThanPlannedMakeLaterOnesCostMore") {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  // The first chunks hold at least twice what was planned: a budget for four has room for two.
  std::atomic<std::size_t> started{0}, running{0}, most_later{0};
  ExecutorOptions options;
  options.threads = 8;
  options.process_bytes = 400 * kMiB;
  options.resident = [&] {
    const bool holds = started > 0 && started < 10;
    return holds ? 800 * kMiB : 0;
  };
  run_chunks(make_tasks(60, 100 * kMiB), options, [&](ChunkId) {
    const std::size_t number = ++started;
    const std::size_t now = ++running;
    if (number > 20) raise_to(most_later, now);
    nap(2000);
    --running;
  });
  CHECK(started == 60);
  CHECK(most_later <= 2);
}

}  // namespace orbweave
