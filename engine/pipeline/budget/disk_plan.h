// How much room a job takes on disk: predicted from the counted cloud, and checked before the work.
#pragma once

#include <cstdint>
#include <filesystem>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "partition/memory_plan.h"

namespace orbweave {

/// A cloud that was counted, as far as room on disk depends on it.
struct CloudSize {
  PointSchema schema;
  std::uint64_t points = 0;
  std::uint64_t chunks = 0;
  std::uint64_t points_without_view = 0;  ///< points whose scanner is not known
  MemoryPlan memory;
  std::uint64_t node_bytes = 0;  ///< of levels of detail that an earlier run left
};

/// What comes between counting the points and cutting them for good.
struct RawWork {
  CleaningOptions cleaning;
  bool estimates = false;        ///< normals
  bool propagates = false;       ///< their side
  std::uint64_t held_bytes = 0;  ///< what the passes left and is needed while the points are cut
};

/// What the job asks for, of points that were counted as they came. What cleaning.auto will choose
/// is not known then: all of it is expected.
RawWork raw_work(const ResolvedJob& job, const CloudSize& scans);

/// Bytes at the fullest moments. Not below what is used, and at most a quarter above, of a surface
/// whose points are all kept and used; points that cleaning drops, and rows of text that are
/// shorter than usual, leave more of it unused. docs/disk.md.
struct DiskPlan {
  std::uint64_t cleaning_bytes = 0;    ///< of the work directory, until the points are cut for good
  std::uint64_t work_bytes = 0;        ///< of the work directory, whenever that is
  std::uint64_t output_bytes = 0;      ///< of the mesh
  std::uint64_t most_bytes = 0;        ///< of both together
  std::uint64_t tileset_bytes = 0;     ///< of the folder of levels of detail
  std::uint64_t simplified_bytes = 0;  ///< of the simplified mesh

  /// Of everything together.
  std::uint64_t all_bytes() const { return most_bytes + tileset_bytes + simplified_bytes; }
};
DiskPlan plan_disk(const ResolvedJob& job, const CloudSize& cloud, const RawWork& raw);

/// Throws Error (resource) where the file systems of the work directory and of the outputs have
/// less room than `plan` asks for beyond the `held_bytes` that the work directory holds already.
/// Says how much is needed, how much is free, and where.
void require_room(const std::filesystem::path& work_dir, const OutputOptions& output,
                  const DiskPlan& plan, std::uint64_t held_bytes);

/// Most that a job holds that found its points cut already. `node_bytes`: of simplified nodes that
/// it found.
std::uint64_t predicted_disk_bytes(const ResolvedJob& job, const Partition& partition,
                                   std::uint64_t node_bytes);

/// Whether the bins of the points take more than their buffers.
bool bins_will_spill(const CloudSize& cloud);

struct RoomPlan {
  /// Of bins that may be there beside what they became: as much as the work directory takes later
  /// in any case.
  std::uint64_t bin_bytes = 0;
  /// Most that work directory and output hold at one time; the leader's alone.
  std::uint64_t predicted_disk_bytes = 0;
};

/// The check before the points are binned that `stages` cut, or where an earlier run has binned
/// them. Only the leader checks. Throws as require_room.
RoomPlan check_room(StageRunner& runner, const CutStages& stages, bool are_scans,
                    const CloudSize& cloud);

}  // namespace orbweave
