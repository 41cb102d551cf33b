// From scan files to chunks: count, cut, bin, sort. The points of every chunk end in the chunk
// store, in canonical order.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/point_stream.h"
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
  std::uint64_t points_read = 0;
  DroppedPoints dropped;
  double spacing = 0.0;  ///< robust nearest-neighbour spacing; 0: unknown
  std::vector<double> automatic_radii;
  std::string radii_reason;

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
  std::uint64_t bytes_read = 0;
  DroppedPoints dropped;
  CountGrid grid;
  Octree octree;
  MemoryPlan memory;
  std::vector<std::string> notes;
};

/// Opens the job's files as one stream. Throws Error (bad input) where they have no normals.
std::unique_ptr<PointSource> open_input(const InputContext& context,
                                        std::vector<std::string>* notes = nullptr);
/// First pass: how many points lie where, and how they are cut into chunks.
CountedCloud count_points(const InputContext& context);

/// Everything that the points in the store depend on, as one text.
std::string partition_key(const Job& job, const std::vector<std::string>& files);

/// What an earlier run left; empty: nothing whole.
std::optional<Partition> stored_partition(const ChunkStore& store);

/// The stage; resumes from the store where it holds a finished partition under the same key.
Partition partition_points(JobContext& context);

}  // namespace orbweave
