// Passes over the points of raw scans: each takes the points of a chunk and its halo as the pass
// before left them, and leaves its own in the store. Points stay with the chunk that the raw
// partition gave them to, and in its order, even where they are moved out of its cube.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/normals/estimate_normals.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/report/reasons.h"

namespace orbweave {

/// Where the points of the raw scans have got to.
struct RawCloud {
  Partition partition;  ///< of the raw points; all passes keep its chunks
  std::string stage;    ///< that holds the points now
  std::string key;      ///< everything that they depend on
  PointSchema schema;   ///< of the points now
  double drift = 0.0;   ///< how far a point may have left the cube of its chunk
  std::uint64_t points = 0;
  DroppedPoints dropped;
  std::string kept_stage = {};  ///< whose points are still needed; others go when they were used
};

/// A chunk's points with those of its halo, in raw order.
struct PassPoints {
  /// A chunk whose points are among these: the number of its first, and those that are here.
  struct Source {
    std::uint64_t first_number = 0;
    std::vector<std::uint32_t> rows;
  };
  std::vector<Vec3> positions;
  std::vector<Vec3> normals;  ///< empty without
  std::uint32_t begin = 0;    ///< the chunk's own points
  std::uint32_t end = 0;
  PointCloud own;                     ///< these, with their attributes
  std::uint64_t first_number = 0;     ///< of these
  std::vector<Source> before, after;  ///< the others

  /// Numbers of the points, ascending.
  std::vector<std::uint64_t> numbers() const;
};

/// What a pass leaves of a chunk's own points, in their order.
struct PassResult {
  PointCloud points;
  /// Where each was among the chunk's own points, where a later step asks for that.
  std::vector<std::uint32_t> rows = {};
  std::uint64_t also_dropped = 0;  ///< points that are missing for the pass's other reason
};

struct RawPass {
  std::string stage;          ///< for its points
  std::string options;        ///< what it depends on beside the points, as lines of a key
  double halo = 0.0;          ///< world units
  double drift = 0.0;         ///< farthest that it moves a point
  bool adds_normals = false;  ///< (of 32 bits)
  std::optional<PointSchema> schema = {};  ///< of the points that it leaves; empty: as before
  DropReason dropped_reason = DropReason::kNone;  ///< why points may be missing afterwards
  DropReason also_reason = DropReason::kNone;     ///< why others may
  std::function<PassResult(PassPoints&&)> work;
  /// Called with what the pass leaves of a chunk, before that is committed; empty: nothing is.
  std::function<void(ChunkId, const PassResult&)> look = {};
};

/// Calls `visit` for every chunk whose result `stage` lacks, in parallel, with its points and halo.
void visit_chunks(StageRunner& runner, const RawCloud& cloud, const std::string& stage, double halo,
                  const std::function<void(ChunkId, PassPoints&&)>& visit);

/// Thrown where a pass has to be run again and the points that it was made from have been removed.
struct RawPointsGone {};

/// Throws RawPointsGone where the points of the cloud have been removed: an earlier run, of a job
/// with more passes, no longer needed them. Every member calls it.
void require_points(StageRunner& runner, const RawCloud& cloud);

/// The same where `stage` lacks a chunk's result, for which the points are needed.
void require_points_for(StageRunner& runner, const RawCloud& cloud, const std::string& stage);

/// Runs a pass, or takes what an earlier run left of it. When it is complete, the points that it
/// was made from are removed. Throws RawPointsGone, and Error (bad input) where no point is left.
void run_pass(StageRunner& runner, const RawPass& pass, RawCloud& cloud);

}  // namespace orbweave
