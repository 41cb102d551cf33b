// Files that `generate` writes: clouds, and separate scans with their poses.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/synthetic/range_scans.h"
#include "io/meshes/mesh_writer.h"
#include "io/stop_token.h"
#include "io/system/path_roles.h"

namespace orbweave {

/// Where the poses of separate scans stand.
enum class PoseFile {
  kStanford,  ///< a .conf: scanners far away, which look along -z
  kJob        ///< a job file: scanners at the origins of their scans' frames
};

/// How the points of a command are written.
struct PointFiles {
  MeshWriterOptions format;
  double spacing = 0.0;  ///< between neighbouring points, for the message
};

/// Writes a source of points to a file ("-": standard output) and says so.
void write_points(PointSource& source, const std::string& path, const PointFiles& files,
                  const StopToken& stop);

/// Writes all scans, each in its own frame, beside each other ("scans.ply" gives "scans_0.ply",
/// "scans_1.ply", ...), and the file of their poses. Scans without points are named and left out.
void write_separate_scans(const RangeScans& scans, const std::string& out, PoseFile poses,
                          const PointFiles& files, const StopToken& stop);

/// The files that write_separate_scans() writes.
std::vector<PathRole> separate_scan_files(const std::string& out, int scans, PoseFile poses);

}  // namespace orbweave
