#include "engine/pipeline/damage_repair.h"

#include <charconv>
#include <optional>

#include "engine/pipeline/stage/stages.h"
#include "io/store/chunk_points.h"
#include "io/system/owned_files.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// The directory of a stage; files beside the stages count as the points'.
std::string directory_of_file(const fs::path& file) {
  std::string directory = file.parent_path().filename().string();
  return directory.empty() ? std::string(kPointsStage) : directory;
}

StageRepair repair_of(const std::string& directory) {
  const StageInfo* info = stage_in(directory);
  return info == nullptr ? StageRepair::kStage : info->repair;
}

/// The chunk of a result, by its file name.
std::optional<ChunkId> chunk_of(const fs::path& file) {
  const std::string name = file.stem().string();
  ChunkId chunk = 0;
  const auto parsed = std::from_chars(name.data(), name.data() + name.size(), chunk);
  if (parsed.ec != std::errc()) return std::nullopt;
  return chunk;
}

}  // namespace

void drop_damaged(ChunkStore& store, const fs::path& file) {
  const std::string directory = directory_of_file(file);
  const StageRepair repair = repair_of(directory);
  const std::optional<ChunkId> chunk = chunk_of(file);
  if (repair == StageRepair::kChunk && chunk) {
    store.discard(directory, *chunk);
    store.discard_damaged(directory);  // its siblings may have come from elsewhere along with it
  } else if (repair == StageRepair::kLine) {
    discard_raw_stages(store);
  } else {
    store.discard_stage(directory);
    // Bins go as chunks are sorted.
    if (repair == StageRepair::kStageAndCut) store.discard_stage(kFinalCut.cut());
  }
  // A stranger's file would be found again and again.
  std::error_code ignored;
  const bool stays = fs::exists(fs::symlink_status(file, ignored));
  if (stays && !store.record()->owns(file)) throw_stranger(file);
}

bool Repairs::allow(const fs::path& file) {
  constexpr int kMostOfFile = 3;
  constexpr int kMostBeginnings = 8;
  const bool is_chunk_alone = repair_of(directory_of_file(file)) == StageRepair::kChunk;
  if (!is_chunk_alone && ++beginnings_ > kMostBeginnings) return false;
  return ++of_file_[file.native()] <= kMostOfFile;
}

}  // namespace orbweave
