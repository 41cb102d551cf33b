#include "engine/pipeline/job_context.h"

#include <sys/resource.h>

#include <chrono>

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

}  // namespace

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
  facts_.bytes_read += context_.store.bytes_read() - read_begin_;
  facts_.bytes_written += context_.store.bytes_written() - written_begin_;
  context_.report.stages.push_back(facts_);
  context_.progress.end_stage();
}

}  // namespace orbweave
