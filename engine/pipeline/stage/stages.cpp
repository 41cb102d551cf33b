#include "engine/pipeline/stage/stages.h"

#include <algorithm>

namespace orbweave {
namespace {

bool stores(const StageInfo& info) { return *info.directory != '\0'; }

/// Adds the stage's directories that are not there yet.
void add_directories(const StageInfo& info, std::vector<std::string>& directories) {
  if (!stores(info)) return;
  for (int repeat = 0; repeat < info.repeats; ++repeat) {
    std::string name = info.repeats == 1 ? info.directory : directory_of(info.stage, repeat + 1);
    if (std::find(directories.begin(), directories.end(), name) == directories.end())
      directories.push_back(std::move(name));
  }
}

template <class Wanted>
std::vector<std::string> directories_where(const Wanted& wanted) {
  std::vector<std::string> directories;
  for (const StageInfo& info : kStages)
    if (wanted(info)) add_directories(info, directories);
  return directories;
}

}  // namespace

std::string directory_of(Stage stage, int repeat) {
  return std::string(directory_of(stage)) + "_" + std::to_string(repeat);
}

const StageInfo* stage_in(std::string_view directory) {
  for (const StageInfo& info : kStages) {
    std::vector<std::string> own;
    add_directories(info, own);
    if (std::find(own.begin(), own.end(), directory) != own.end()) return &info;
  }
  return nullptr;
}

std::vector<std::string> directories_of(StageLine line) {
  return directories_where(
      [&](const StageInfo& info) { return info.line == line && info.goes_with_line; });
}

std::vector<std::string> directories_from(std::string_view directory) {
  const StageInfo* info = stage_in(directory);
  if (info == nullptr) return {std::string(directory)};
  std::vector<std::string> all = directories_of(info->line);
  all.erase(all.begin(), std::find(all.begin(), all.end(), directory));
  return all;
}

std::vector<std::string> raw_directories() {
  return directories_where([](const StageInfo& info) { return info.line == StageLine::kRaw; });
}

std::vector<std::string> directories_dropped_by_fresh() {
  return directories_where([](const StageInfo& info) { return info.dropped_by_fresh; });
}

void discard_raw_stages(ChunkStore& store) {
  for (const std::string& directory : raw_directories()) store.discard_stage(directory);
}

}  // namespace orbweave
