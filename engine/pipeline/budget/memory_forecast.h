// How much memory a job takes: of chunks with their halos, and of the job at its fullest.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"

namespace orbweave {

/// Points of every chunk and its halo, at least, and at most a block of rows more for every block
/// at the border. Reads the bounds of all blocks (48 bytes per 1024 points) from the store.
std::vector<std::uint64_t> points_with_halos(const ChunkStore& store, const Partition& partition,
                                             double halo_width);

/// The forecast before points are sorted: as if the points of a chunk lay on a surface, at the
/// point spacing of the whole cloud, or those of its neighbours all over their cubes, whichever is
/// more.
std::vector<std::uint64_t> expected_points_with_halos(const Partition& partition,
                                                      double halo_width);

/// Points of a chunk and its halo, at most, that the memory has room for where no other chunk is
/// worked on.
std::uint64_t most_points_with_halo(const ResolvedJob& job);

/// Peak of the process. `partition` needs schema, octree, spacing and, of scans that are to be
/// cleaned, normal_radius and layers; `radii` are those of the job. Holes that are filled may take
/// more: predicted_hole_bytes.
std::uint64_t predicted_peak_bytes(const ResolvedJob& job, const Partition& partition,
                                   std::span<const double> radii);

/// What the stage of the holes has to hold, known when the boundary is.
struct HoleLoad {
  std::uint64_t edges = 0;  ///< of the boundary
  std::uint64_t loops = 0;
  std::uint64_t chunk_bytes = 0;      ///< of the largest chunk that is looked at
  std::uint64_t batch_bytes = 0;      ///< of the largest batch of holes
  std::uint64_t all_chunk_bytes = 0;  ///< of all chunks with a boundary
  std::uint64_t pieces = 0;           ///< connected ones, of the mesh or of all chunks' meshes
  /// Of the largest hole with its patch, as far as the rim tells. The budget need not hold that
  /// much: many such loops stay open and cost nothing.
  std::uint64_t patch_bytes = 0;
};

/// Peak of the process in the stage of the holes.
std::uint64_t predicted_hole_bytes(const ResolvedJob& job, const Partition& partition,
                                   const HoleLoad& load);

/// Throws Error (resource) where the boundary, one chunk and one batch of holes take more than the
/// budget, and says how much that is.
void require_memory_for_holes(const ResolvedJob& job, const Partition& partition,
                              const HoleLoad& load);

/// Peak of the process while so much boundary is stitched and, where holes are filled, traced.
std::uint64_t boundary_bytes(const ResolvedJob& job, const Partition& partition,
                             const HoleLoad& load);

/// Throws Error (resource) where that is more than the budget, and says how much it is.
void require_memory_for_boundary(const ResolvedJob& job, const Partition& partition,
                                 const HoleLoad& load);

/// Throws Error (resource) where a chunk with its halo alone takes more than the budget, and says
/// how much that is.
void require_memory_for_largest(const ResolvedJob& job, const Partition& partition,
                                std::span<const std::uint64_t> points,
                                std::span<const double> radii);

/// What is to be said of a predicted peak beyond what the system lets the process have
/// (io/system/memory_limit.h); empty: nothing.
std::string objection_to_peak(const Job& job, std::uint64_t predicted_bytes,
                              std::optional<std::uint64_t> limit_bytes);

}  // namespace orbweave
