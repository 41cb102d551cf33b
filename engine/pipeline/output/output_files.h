// The files that a run leaves, and those of earlier runs that could be taken for them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/pipeline/stage/stage_runner.h"
#include "io/job/job.h"

namespace orbweave {

struct OutputFile {
  /// "mesh", "numbers", "tiles", "system", "shift", "tileset", "simplified", "polygons",
  /// "medial axis", "report", "page", "picture"
  const char* role;
  std::filesystem::path file;
};

/// What has to be said of the coordinates in files of their own.
struct BesideMesh {
  bool system = false;               ///< the scans have a coordinate system
  bool shift = false;                ///< coordinates are counted from an origin
  bool shift_of_simplified = false;  ///< likewise those of the simplified mesh
};

/// What a run of this job writes, in the order of a summary; nothing for a mesh to standard output
/// but what lies beside it.
std::vector<OutputFile> written_outputs(const OutputOptions& output, BesideMesh beside);

/// What is there under a name that another run of this job would have written, and this one has
/// not: a mesh beside tiles, tiles beside a mesh, a coordinate system where there is none.
/// `has_system`: the scans have a coordinate system. An older shift is set to 0 where it is
/// written.
std::vector<OutputFile> older_outputs(const OutputOptions& output, bool has_system);

/// Removes older outputs that the record of this work directory knows for the program's own, and
/// warns of the others.
void clear_older_outputs(StageRunner& runner, bool has_system);

}  // namespace orbweave
