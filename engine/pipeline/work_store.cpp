#include "engine/pipeline/work_store.h"

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>

#include "engine/pipeline/run_steps.h"
#include "engine/pipeline/stage/stages.h"
#include "io/error.h"
#include "io/report/logged_progress.h"
#include "io/stop_token.h"
#include "io/store/store_lock.h"

namespace orbweave {
namespace {

/// What tells the work directory of this run from others of that name.
std::uint64_t mark_of_run() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(now.count()) * 4194304 + static_cast<std::uint64_t>(getpid());
}

/// Returns whether the file holds `text`, or does some seconds later: file systems over a network
/// remember for a while what was there before.
bool will_hold(const std::filesystem::path& file, const std::string& text, const StopToken& stop) {
  constexpr int kTries = 50;
  for (int i = 0; i < kTries; ++i) {
    if (line_of_lock(file) == text) return true;
    stop.check();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

[[noreturn]] void throw_not_shared(const std::filesystem::path& directory) {
  throw_resource("the work directory is not the one that the leader of the job uses",
                 {.file = directory.string(),
                  .expected = "a directory that all processes share",
                  .advice = "Name one on a shared file system with run.work_dir or --work-dir"});
}

/// A member's store, where the directory is the leader's own.
std::unique_ptr<ChunkStore> join_root(const std::filesystem::path& directory,
                                      Communicator& communicator, const StopToken& stop) {
  const std::string mark = std::to_string(communicator.broadcast(0, stop));
  if (!will_hold(directory / kTeamMark, mark, stop)) throw_not_shared(directory);
  auto store = ChunkStore::join(directory, communicator.rank());
  // The leader may have died by now, and another run be at work, whose member wants this place.
  if (line_of_lock(directory / kTeamMark) != mark) throw_not_shared(directory);
  return store;
}

std::unique_ptr<ChunkStore> open_as_root(const RunOptions& run, Communicator& communicator,
                                         const StopToken& stop) {
  auto store = std::make_unique<ChunkStore>(run.work_dir);
  if (run.fresh) {
    store->clear_ended();
    for (const std::string& directory : directories_dropped_by_fresh())
      store->discard_stage(directory);
  }
  if (communicator.size() == 1) return store;
  const std::uint64_t mine = mark_of_run();
  store->mark_team(std::to_string(mine));
  communicator.broadcast(mine, stop);
  return store;
}

std::string log_name(const Communicator& communicator) {
  return communicator.is_root() ? kLogName
                                : "orbweave.rank" + std::to_string(communicator.rank()) + ".log";
}

}  // namespace

std::unique_ptr<ChunkStore> open_work_store(const RunOptions& run, Communicator& communicator,
                                            const StopToken& stop) {
  return communicator.is_root() ? open_as_root(run, communicator, stop)
                                : join_root(run.work_dir, communicator, stop);
}

std::unique_ptr<Progress> open_log(Progress& progress, ChunkStore& store,
                                   const Communicator& communicator) {
  const std::filesystem::path log = store.directory() / log_name(communicator);
  const bool is_ours = store.claim(log);
  if (!is_ours) progress.warn(log.string() + ": not on record as a log of this job; goes without");
  auto logged = make_logged_progress(progress, is_ours ? log : std::filesystem::path());
  const std::filesystem::path steps = store.directory() / kStepsName;
  if (!communicator.is_root() || !store.claim(steps)) return logged;
  return make_recorded_progress(std::move(logged), steps);
}

}  // namespace orbweave
