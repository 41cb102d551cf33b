#include "engine/pipeline/stage/stage_runner.h"

#include <algorithm>
#include <bit>
#include <mutex>

#include "io/system/process_times.h"

namespace orbweave {
namespace {

/// Shows the leader's reader what the others have done.
void show_done_by_others(StageRunner& runner) {
  if (!runner.communicator.is_root()) return;
  const Communicator::Done done = runner.communicator.done_by_others();
  runner.progress.advance(done.units);
  runner.progress.add_points(done.points);
}

}  // namespace

void share_chunks(StageRunner& runner, StageClock& clock, const std::string& stage,
                  std::vector<ChunkWork> chunks, std::size_t memory_bytes,
                  const std::function<void(ChunkId)>& work, Durability durability) {
  // A long task that starts last is what everybody would wait for. Tasks of about the same length
  // stay in the order of the chunks, and a process takes several in a row: halos are then read
  // while they are still in memory.
  std::stable_sort(chunks.begin(), chunks.end(), [](const ChunkWork& a, const ChunkWork& b) {
    return std::bit_width(a.length) > std::bit_width(b.length);
  });
  std::vector<ChunkTask> tasks;
  for (const ChunkWork& chunk : chunks) {
    tasks.push_back({static_cast<ChunkId>(tasks.size()), chunk.memory_bytes, chunk.length});
  }
  std::mutex mutex;
  runner.communicator.reset_counter(runner.stop);
  run_chunks(tasks,
             {runner.threads(), memory_bytes, &runner.stop, &runner.communicator,
              runner.root_threads, runner.job.partition.memory_bytes},
             [&](ChunkId task) {
               const ChunkWork& chunk = chunks[task];
               const bool reused = runner.store.has(stage, chunk.chunk);
               const double begin = steady_seconds(), cpu_begin = thread_cpu_seconds();
               if (!reused) work(chunk.chunk);
               const double seconds = steady_seconds() - begin;
               const double cpu_seconds = thread_cpu_seconds() - cpu_begin;
               runner.communicator.add_done(1, reused ? 0 : chunk.points);
               runner.progress.advance(1);
               if (!reused) runner.progress.add_points(chunk.points);
               const std::scoped_lock lock(mutex);
               if (reused) {
                 ++clock.facts().chunks_reused;
               } else {
                 clock.facts().chunk_seconds.push_back(seconds);
                 clock.facts().chunk_cpu_seconds.push_back(cpu_seconds);
               }
               show_done_by_others(runner);
             });
  if (durability == Durability::kAwaited) runner.store.finish_commits();
  show_commits(runner);
  runner.communicator.barrier(runner.stop, [&] { show_done_by_others(runner); });
  if (runner.communicator.is_root() && runner.communicator.size() > 1) {
    // The others' results are not among what this process wrote.
    runner.store.disk().set(room_of_directory(runner.store.directory()));
  }
  show_done_by_others(runner);
  clock.facts().chunks = chunks.size();
}

void show_commits(StageRunner& runner) {
  if (runner.communicator.size() > 1) return runner.store.finish_commits();
  // Nothing is waited for, but the flush begins now: beside the next stage's work, not beside its
  // writes.
  runner.store.await_durable(0);
}

void by_root(StageRunner& runner, const std::function<void()>& work) {
  if (runner.communicator.is_root()) work();
  runner.communicator.barrier(runner.stop);
}

StageClock::StageClock(StageRunner& runner, Stage stage, std::uint64_t total,
                       const std::string& unit)
    : StageClock(runner, std::string(name_of(stage)), total, unit) {}

StageClock::StageClock(StageRunner& runner, const std::string& name, std::uint64_t total,
                       const std::string& unit)
    : runner_(runner),
      wall_begin_(steady_seconds()),
      cpu_begin_(process_cpu_seconds()),
      read_begin_(runner.store.bytes_read()),
      written_begin_(runner.store.bytes_written()),
      calls_begin_(runner.communicator.counter_calls()) {
  facts_.name = name;
  runner.progress.begin_stage(name, total, unit);
}

StageClock::~StageClock() {
  facts_.seconds = steady_seconds() - wall_begin_;
  facts_.cpu_seconds = process_cpu_seconds() - cpu_begin_;
  facts_.peak_memory_bytes = memory_.peak_bytes();
  facts_.bytes_read += runner_.store.bytes_read() - read_begin_;
  facts_.bytes_written += runner_.store.bytes_written() - written_begin_;
  facts_.counter_calls = runner_.communicator.counter_calls() - calls_begin_;
  runner_.measured.push_back(facts_);
  runner_.progress.end_stage();
}

}  // namespace orbweave
