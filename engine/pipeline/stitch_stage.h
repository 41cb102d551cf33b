// What the chunks' meshes are together: counts, the boundary of the whole, and how much of it every
// chunk has. The leader puts it together from what the chunks say of their borders and leaves it in
// the store; everybody else, and a run that was interrupted later, reads it there.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/pipeline/job_context.h"
#include "engine/pipeline/partition_stage.h"
#include "engine/stitching/mesh_summary.h"

namespace orbweave {

inline constexpr const char* kStitchStage = "stitch";

struct Stitched {
  MeshFacts facts;                       ///< counts and area; the exporter adds the rest
  StitchedBoundary boundary;             ///< nothing where no holes are filled
  std::vector<std::uint64_t> triangles;  ///< per chunk
  std::vector<std::uint32_t> used;       ///< points, as append_used_counts counts them
  std::uint64_t conflicts_lost = 0;
  std::uint64_t unused_points = 0;
};

/// Looks at the borders of all chunks, one after the other. Throws Error (resource) where the
/// boundary does not fit the memory budget, before it is read, and says how much would do.
Stitched stitch_chunks(JobContext& context, const Partition& partition);

/// The stage. Throws as stitch_chunks, and Error (bad input) where no triangle was found.
Stitched stitch(JobContext& context, const Partition& partition, const std::vector<double>& radii);

/// What an earlier run left of the same mesh. Throws as stitch_chunks where it does not fit the
/// budget, before the boundary is read.
std::optional<Stitched> stored_stitch(const JobContext& context, const Partition& partition,
                                      const std::vector<double>& radii);

/// Removes what is stored where the mesh of some chunk is about to be made anew. Only the leader
/// calls it.
void drop_stitch_of_unfinished_mesh(JobContext& context, const Partition& partition);

}  // namespace orbweave
