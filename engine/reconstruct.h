// The front door: from points in memory to a mesh in memory. docs/library.md has examples.
#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "io/error.h"
#include "io/hole_facts.h"
#include "io/point_cloud.h"
#include "io/points/dropped_points.h"
#include "io/stop_token.h"
#include "io/surface_options.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// Defaults are those of a job.
struct ReconstructionOptions {
  /// Ball radii in ascending order, world units; empty: chosen from the distances between points.
  std::vector<double> ball_radii;
  int levels = 0;         ///< number of chosen radii, 1 to 8; 0: as the density of points asks for
  NormalOptions normals;  ///< Orientation::kScanner is not available for points in memory
  FillOptions fill;
  /// No-data values, several points at exactly (0, 0, 0) and strays are points like any others.
  bool keep_strays = false;
  int threads = 0;  ///< 0: those of the calling TBB arena
  /// Called by one thread whenever a stage begins, with its name and the share of the stages that
  /// are done: "measure", "sort", "normals", "orient", "reconstruct", "fill". May be empty.
  std::function<void(std::string_view stage, double done)> progress;
  const StopToken* stop = nullptr;  ///< looked at every few milliseconds; may be null
};

struct Reconstruction {
  /// Vertices are points of the cloud, unmoved, in canonical order, with all their attributes; then
  /// the vertices of patches. `mesh.hole` tells the triangles of patches.
  TriangleMesh mesh;
  std::vector<HoleFacts> holes;    ///< every boundary loop, filled or not; empty without the fill
  std::vector<double> ball_radii;  ///< that were used, ascending
  DroppedPoints dropped;           ///< points that were left out beforehand, by reason
};

/// Reconstructs the surface of a cloud. The mesh, written as a PLY file, has the bytes of the file
/// that `orbweave reconstruct` makes of the same points, and does not depend on their order nor on
/// the number of threads. Normals are estimated where the cloud has none; those it has are taken at
/// the width that `cloud.schema.normal_type` says. Holds some 400 bytes per point. Throws Error:
/// usage for options out of range, bad input where no triangle can be formed, interrupted when
/// `options.stop` is requested. Changes no global state.
Reconstruction reconstruct(PointCloud cloud, const ReconstructionOptions& options = {});

/// The same for points that the caller keeps: copies them once, into the canonical order (once more
/// where some are left out). `normals` is as long as `positions` or empty; taken as doubles.
Reconstruction reconstruct(std::span<const Vec3> positions, std::span<const Vec3> normals,
                           const ReconstructionOptions& options = {});

}  // namespace orbweave
