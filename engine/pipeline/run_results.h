// The results of a run's stages, and the report that is made from them at the end.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline/output/mesh_for_levels.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/pipeline/surface/surface_inputs.h"

namespace orbweave {

struct RunResults {
  Partition partition;
  BallRadii radii;
  Vec3 origin;  ///< of the mesh file's coordinates
  std::uint64_t conflicts_lost = 0;
  std::uint64_t points_unused = 0;   ///< kept, but no triangle uses them
  std::uint64_t pieces_removed = 0;  ///< smaller than fill.min_triangles
  std::uint64_t triangles_removed = 0;
  std::optional<VoronoiFacts> voronoi;
  SideFacts sides;  ///< of normals whose side was given
  MeshFacts mesh;
  MeshFileState mesh_file;       ///< as it was written, where levels of detail are made of it
  std::vector<HoleFacts> holes;  ///< first vertices in the output's numbers
  ResourceFacts predicted;
};

/// The report of a run, from what its runner measured and said and from the stages' results.
RunReport report_of(const StageRunner& runner, const std::vector<std::string>& command,
                    RunResults results, const ResourceFacts& measured);

/// The job alone, for a run with nothing else to tell.
RunReport report_of_job(const ResolvedJob& job, const std::vector<std::string>& command,
                        int processes);

}  // namespace orbweave
