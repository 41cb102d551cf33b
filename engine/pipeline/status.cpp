// What a work directory tells about the run that uses or used it.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <fstream>

#include "engine/pipeline/partition_stage.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/prepare_stage.h"
#include "engine/pipeline/reconstruct_stage.h"
#include "io/chunk_points.h"
#include "io/error.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

std::uint64_t committed_chunks(const fs::path& stage) {
  std::uint64_t count = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(stage, ignored)) {
    const std::string name = entry.path().filename().string();
    count += name.ends_with(".h5") && !name.starts_with(".") ? 1 : 0;
  }
  return count;
}

/// Whether some process holds the lock.
bool is_locked(const fs::path& lock) {
  const int descriptor = open(lock.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool held = flock(descriptor, LOCK_SH | LOCK_NB) != 0;
  close(descriptor);
  return held;
}

std::string iso_time(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  const std::time_t seconds = std::chrono::system_clock::to_time_t(
      std::chrono::time_point_cast<std::chrono::seconds>(system));
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

std::string last_touched(const fs::path& directory) {
  fs::file_time_type latest = fs::last_write_time(directory);
  std::error_code ignored;
  for (const auto& entry : fs::recursive_directory_iterator(directory, ignored)) {
    const auto time = entry.last_write_time(ignored);
    if (!ignored) latest = std::max(latest, time);
  }
  return iso_time(latest);
}

std::uint64_t chunks_of(const fs::path& document) {
  std::ifstream file(document);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  return text.empty() ? 0 : partition_from_json(text).octree.chunks().size();
}

StageStatus stage_status(const fs::path& work_dir, const std::string& stage, std::uint64_t total) {
  const std::uint64_t done = committed_chunks(work_dir / stage);
  return {stage, done, total, total > 0 && done == total};
}

}  // namespace

WorkStatus work_status(const fs::path& work_dir) {
  if (!fs::exists(work_dir / "orbweave-store.json")) {
    throw_usage("is no work directory of orbweave",
                {.file = work_dir.string(),
                 .place = {},
                 .found = fs::exists(work_dir) ? "no orbweave-store.json in it" : "nothing there",
                 .expected = "the work_dir of a job",
                 .advice = {}});
  }
  WorkStatus status;
  const fs::path document = work_dir / kPointsStage / "partition.json";
  const std::uint64_t total = chunks_of(document);
  // Passes over raw points are gone once the points are cut into chunks for good.
  const std::uint64_t raw_total = chunks_of(work_dir / raw_stages().front() / "partition.json");
  for (const std::string& stage : raw_stages())
    if (total == 0 && fs::exists(work_dir / stage))
      status.stages.push_back(stage_status(work_dir, stage, raw_total));
  for (const char* stage : {kPointsStage, kMeshStage})
    status.stages.push_back(stage_status(work_dir, stage, total));
  status.running = is_locked(work_dir / "lock");
  if (status.running) std::ifstream(work_dir / "lock") >> status.process_id;
  status.last_touched = last_touched(work_dir);
  return status;
}

}  // namespace orbweave
