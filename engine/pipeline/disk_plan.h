// How much room a job takes on disk: predicted from the counted cloud, and checked before the work.
#pragma once

#include <cstdint>
#include <filesystem>

#include "engine/pipeline/partition_stage.h"

namespace orbweave {

/// What comes between counting the points and cutting them for good.
struct RawWork {
  PrepareOptions clean_up;
  bool estimates = false;        ///< normals
  bool propagates = false;       ///< their side
  std::uint64_t held_bytes = 0;  ///< what the passes left and is needed while the points are cut
};

/// What the job asks for, of points that were counted as they came. What prepare.auto will choose
/// is not known then: all of it is expected.
RawWork raw_work(const InputContext& context, const CountedCloud& scans);

/// Bytes at the fullest moments. Not below what is used, and at most a quarter above, of a surface
/// whose points are all kept and used; points that clean-up drops, and rows of text that are
/// shorter than usual, leave more of it unused. docs/disk.md.
struct DiskPlan {
  std::uint64_t prepare_bytes = 0;  ///< of the work directory, until the points are cut for good
  std::uint64_t work_bytes = 0;     ///< of the work directory, whenever that is
  std::uint64_t output_bytes = 0;   ///< of the mesh
  std::uint64_t most_bytes = 0;     ///< of both together
};
DiskPlan plan_disk(const Job& job, const CountedCloud& cloud, const RawWork& raw);

/// Throws Error (resource) where the file systems of the work directory and of the mesh have less
/// room than `plan` asks for beyond the `held_bytes` that the work directory holds already. Says
/// how much is needed, how much is free, and where.
void require_room(const std::filesystem::path& work_dir, const std::string& mesh,
                  const DiskPlan& plan, std::uint64_t held_bytes);

/// Predicts for the report what a job holds that found its points cut already; a prediction that is
/// there stays.
void predict_room(JobContext& context, const Partition& partition);

/// Whether the bins of the points take more than their buffers.
bool bins_will_spill(const CountedCloud& cloud);

/// The check before the points of `input` are binned, or where an earlier run has binned them; the
/// first prediction goes to the report. Only the leader checks. Returns how many bytes of bins may
/// be there beside what they became: as much as the work directory takes later in any case.
std::uint64_t check_room(JobContext& context, const CloudInput& input, const CountedCloud& cloud);

}  // namespace orbweave
