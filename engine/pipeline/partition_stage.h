// From points to chunks: count, cut, bin, sort. The points of every chunk end in the chunk store,
// in canonical order.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/cleaning/layer_thickness.h"
#include "engine/pipeline/job_context.h"
#include "engine/pipeline/point_stream.h"
#include "io/chunk_points.h"
#include "partition/count_grid.h"
#include "partition/memory_plan.h"
#include "partition/octree.h"

namespace orbweave {

/// What the later stages know of the points; stored as a document beside them.
struct Partition {
  PointSchema schema;
  Box bounds;
  Octree octree;
  std::vector<std::uint64_t> first_vertex;  ///< global number of each chunk's first point; + total
  std::uint64_t memory_bytes = 0;           ///< budget that the chunks were made for
  std::uint64_t points_read = 0;
  DroppedPoints dropped;
  double spacing = 0.0;  ///< robust nearest-neighbour spacing; 0: unknown
  std::vector<double> automatic_radii;
  std::string radii_reason;
  LayerThickness layers;       ///< of the scans as they came; not measured elsewhere
  double normal_radius = 0.0;  ///< within which the neighbours for a normal are found; likewise
  std::uint64_t points_without_view = 0;  ///< points whose scanner is not known
  PrepareFacts prepare;
  NormalFacts normals;
  std::string coordinate_system;

  std::uint64_t points_in(ChunkId chunk) const {
    return first_vertex[chunk + 1] - first_vertex[chunk];
  }
  /// The chunk that a point belongs to, by its global number.
  ChunkId chunk_of(std::uint64_t vertex) const;
  std::uint64_t points() const { return first_vertex.back(); }
};

std::string partition_to_json(const Partition& partition);
Partition partition_from_json(const std::string& text);

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
  std::string coordinate_system;
  CountGrid grid;
  Box bounds;  ///< once the grid is gone
  Octree octree;
  MemoryPlan memory;
  std::vector<std::string> notes;
};

/// Points to be cut into chunks, and where they go.
struct CloudInput {
  /// Opens the points as one stream, the same at every call.
  std::function<std::unique_ptr<PointSource>(std::vector<std::string>* notes)> open;
  std::string stage;      ///< of the store
  std::string prefix;     ///< of the stages' names in the report
  bool are_scans = true;  ///< points as they came, which have not been measured yet
  /// What the order of the points depends on beside the key of the stage, as lines of a key.
  std::string order = {};
};

/// First pass: how many points lie where, and how they are cut into chunks. Throws Error (bad
/// input) where there is no usable point.
CountedCloud count_points(const InputContext& context, const CloudInput& input);

/// What the second pass measures: spacing, radii and, of scans, thickness and reach of normals.
void measure(const InputContext& context, const CloudInput& input, const SpacingSampler& sampler,
             Partition& partition);

/// Chunks as large as the radii that were found ask for, where those are not the ones expected.
Octree final_octree(const InputContext& context, const CountedCloud& cloud,
                    const Partition& measured);

/// All passes: count, bin, sort. The points are in the store then; the partition is not committed
/// yet.
Partition cut_and_sort(JobContext& context, const CloudInput& input);

/// What an earlier run left; empty: nothing whole.
std::optional<Partition> stored_partition(const ChunkStore& store,
                                          const std::string& stage = kPointsStage);
void commit_partition(ChunkStore& store, const std::string& stage, const Partition& partition);

/// Declares what the points of `stage` depend on; returns what an earlier run left of them.
std::optional<Partition> begin_partition(JobContext& context, const std::string& stage,
                                         const std::string& key);
/// All members make it together; the leader's is committed, and everybody gets that. What it was
/// cut from goes.
Partition partition_by_team(JobContext& context, const std::string& stage,
                            const std::function<Partition()>& make);

/// The stage: scans, prepared where the job or the lack of normals asks for it, as chunks of
/// oriented points. Resumes from the store where it holds a finished partition under the same key.
Partition partition_points(JobContext& context);

}  // namespace orbweave
