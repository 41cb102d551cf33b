// Proves that the thread sanitizer sees through TBB: "racy" adds to one sum from all tasks, "clean"
// to a sum per range. The first has to be reported, the second must not be (.ci/tsan).
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string_view>
#include <thread>
#include <vector>

namespace {

constexpr int kThreads = 4;
constexpr int kNumbers = 1 << 16;

/// What tasks write is read by those that wait for them, and handed from thread to thread.
long long clean_sum() {
  std::vector<int> numbers(kNumbers);
  tbb::parallel_for(0, kNumbers, [&](int i) { numbers[i] = i; });
  std::vector<long long> parts(64);
  tbb::task_group group;
  for (std::size_t part = 0; part < parts.size(); ++part)
    group.run([&parts, part] { parts[part] = static_cast<long long>(part); });
  group.wait();
  long long sum = 0;
  for (const long long part : parts) sum += part;
  const auto add = [&](const tbb::blocked_range<int>& range, long long so_far) {
    for (int i = range.begin(); i != range.end(); ++i) so_far += numbers[i];
    return so_far;
  };
  return tbb::parallel_reduce(tbb::blocked_range<int>(0, kNumbers), sum, add, std::plus<>());
}

/// Each of two tasks waits for the other one to begin, so that two threads add to the sum however
/// busy the machine is. The counter is relaxed and puts the additions in no order.
long long racy_sum() {
  constexpr auto kPatience = std::chrono::seconds(20);
  const auto begin = std::chrono::steady_clock::now();
  long long sum = 0;
  std::atomic<int> begun = 0;
  const auto task = [&](int i) {
    begun.fetch_add(1, std::memory_order_relaxed);
    while (begun.load(std::memory_order_relaxed) < 2 &&
           std::chrono::steady_clock::now() - begin < kPatience)
      std::this_thread::yield();
    sum += i;
  };
  tbb::parallel_for(0, 2, task, tbb::simple_partitioner());
  return sum;
}

}  // namespace

int main(int argc, char** argv) {
  const bool racy = argc > 1 && std::string_view(argv[1]) == "racy";
  // More than the machine has, if need be: TBB would start no more than that.
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, kThreads);
  tbb::task_arena arena(kThreads);
  for (int round = 0; round < 20; ++round)
    arena.execute([&] { std::printf("%lld\n", racy ? racy_sum() : clean_sum()); });
}
