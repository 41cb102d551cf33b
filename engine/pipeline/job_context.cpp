#include "engine/pipeline/job_context.h"

#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <mutex>

namespace orbweave {
namespace {

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Shows the leader's reader what the others have done.
void show_done_by_others(JobContext& context) {
  if (!context.team.leads()) return;
  const Team::Done done = context.team.done_by_others();
  context.progress.advance(done.units);
  context.progress.add_points(done.points);
}

}  // namespace

void share_chunks(JobContext& context, StageClock& clock, const std::string& stage,
                  std::vector<ChunkWork> chunks, std::size_t memory_bytes,
                  const std::function<void(ChunkId)>& work) {
  // A long task that starts last is what everybody would wait for. Tasks of about the same length
  // stay in the order of the chunks, whose halos are then read while they are still in memory.
  std::stable_sort(chunks.begin(), chunks.end(), [](const ChunkWork& a, const ChunkWork& b) {
    return std::bit_width(a.length) > std::bit_width(b.length);
  });
  std::vector<ChunkTask> tasks;
  for (const ChunkWork& chunk : chunks) {
    tasks.push_back({static_cast<ChunkId>(tasks.size()), chunk.memory_bytes});
  }
  std::mutex mutex;
  context.team.start_counting(context.stop);
  run_chunks(tasks,
             {context.threads(), memory_bytes, &context.stop, &context.team,
              context.job.partition.memory_bytes},
             [&](ChunkId task) {
               const ChunkWork& chunk = chunks[task];
               const bool reused = context.store.has(stage, chunk.chunk);
               const double begin = wall_seconds();
               if (!reused) work(chunk.chunk);
               const double seconds = wall_seconds() - begin;
               context.team.add_done(1, reused ? 0 : chunk.points);
               context.progress.advance(1);
               if (!reused) context.progress.add_points(chunk.points);
               const std::scoped_lock lock(mutex);
               if (reused) {
                 ++clock.facts().chunks_reused;
               } else {
                 clock.facts().chunk_seconds.push_back(seconds);
               }
               show_done_by_others(context);
             });
  context.store.finish_commits();
  context.team.meet(context.stop, [&] { show_done_by_others(context); });
  if (context.team.leads() && context.team.size() > 1) {
    // The others' results are not among what this process wrote.
    context.store.disk().set(room_of_directory(context.store.directory()));
  }
  show_done_by_others(context);
  clock.facts().chunks = chunks.size();
}

void by_leader(JobContext& context, const std::function<void()>& work) {
  if (context.team.leads()) work();
  context.team.meet(context.stop);
}

StageClock::StageClock(JobContext& context, const std::string& name, std::uint64_t total,
                       const std::string& unit)
    : context_(context),
      wall_begin_(wall_seconds()),
      cpu_begin_(cpu_seconds()),
      read_begin_(context.store.bytes_read()),
      written_begin_(context.store.bytes_written()) {
  facts_.name = name;
  context.progress.begin_stage(name, total, unit);
}

StageClock::~StageClock() {
  facts_.seconds = wall_seconds() - wall_begin_;
  facts_.cpu_seconds = cpu_seconds() - cpu_begin_;
  facts_.peak_memory_bytes = memory_.peak_bytes();
  facts_.bytes_read += context_.store.bytes_read() - read_begin_;
  facts_.bytes_written += context_.store.bytes_written() - written_begin_;
  context_.report.stages.push_back(facts_);
  context_.progress.end_stage();
}

}  // namespace orbweave
