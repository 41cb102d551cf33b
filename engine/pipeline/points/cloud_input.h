// A cloud on its way into chunks: where its points come from, and what the first pass finds.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline/budget/disk_plan.h"
#include "engine/pipeline/points/halo_work.h"
#include "engine/pipeline/points/point_stream.h"
#include "engine/pipeline/points/remembered_points.h"
#include "engine/pipeline/points/scan_extents.h"
#include "engine/pipeline/stage/stages.h"
#include "partition/count_grid.h"
#include "partition/memory_plan.h"
#include "partition/octree.h"

namespace orbweave {

/// What the first pass finds: counts, bounds and the octree that they lead to.
struct CountedCloud {
  PointSchema schema;
  std::uint64_t points_read = 0;
  std::uint64_t points_used = 0;
  std::uint64_t own_share = 0;      ///< of points_read, that this member of the team has read
  std::uint64_t rows_left_out = 0;  ///< of points_read, that hold no wanted point
  std::uint64_t bytes_read = 0;
  DroppedPoints dropped;
  std::uint64_t points_without_view = 0;
  PointFilter filter;                          ///< what the points counted have passed
  std::vector<std::uint64_t> at_scan_origins;  ///< of the points counted, at each of the filter's
  std::string coordinate_system;
  std::optional<Vec3> meters_per_unit;  ///< of x, y and z; empty: not known
  bool has_wide_colors = false;         ///< 16-bit colours beyond 255, of the points counted
  RememberedPoints remembered;          ///< those that were counted, where they fit in memory
  CountGrid grid;
  /// Where points crowd; empty where the job says how large chunks are, and where there is one
  /// chunk or so many that few of them lie near a crowd.
  std::vector<CrowdedPlace> places;
  Box bounds;  ///< once the grid is gone
  Octree octree;
  MemoryPlan memory;
  ScanExtents extents;  ///< of the scans, while they are counted
  std::vector<std::string> notes;
  std::vector<std::string> doubts;  ///< to be warned of
};

/// What the plan of the disk depends on.
inline CloudSize size_of(const CountedCloud& cloud) {
  return {cloud.schema, cloud.points_used, cloud.octree.chunks().size(), cloud.points_without_view,
          cloud.memory};
}

/// Points to be cut into chunks, and where they go.
struct CloudInput {
  /// Opens the points as one stream, the same at every call.
  std::function<std::unique_ptr<PointSource>(std::vector<std::string>* notes)> open;
  CutStages stages = kFinalCut;
  bool are_scans = true;  ///< points as they came, which have not been measured yet
  /// What the order of the points depends on beside the key of the stage, as lines of a key.
  std::string order = {};
  /// Strays, no-data values and missing returns are left out.
  bool leaves_out_strays = false;
  std::vector<Vec3> scan_origins =
      {};  ///< where the scans' own (0, 0, 0) lie; ascending, different
  /// Automatic radii over the spacing, as the raw points let expect them; empty: not measured.
  std::vector<double> likely_radii = {};
};

}  // namespace orbweave
