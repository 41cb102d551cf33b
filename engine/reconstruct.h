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

/// Defaults are those of a job. Most programs set none of them; the first to try are `ball_radii`
/// where detail is lost or holes remain, and `fill.enabled`.
struct ReconstructionOptions {
  /// Ball radii, positive and ascending, world units. A larger radius closes sparser parts and
  /// loses detail that is finer than the ball. Default: empty, chosen from the distances between
  /// points.
  std::vector<double> ball_radii;
  /// Number of chosen radii, 1 to 8. Without effect where `ball_radii` are given. Default: 0, as
  /// many as the density of the points asks for.
  int levels = 0;
  /// Without effect on a cloud that has normals, unless `normals.source` is kEstimate.
  NormalOptions normals;
  /// Where each point was seen from, as many as points: estimated normals point there, where
  /// `normals.orientation` is kAuto, kGround or kScanner and all are finite. Without effect on a
  /// cloud that keeps its normals. Have to outlive the call. Default: empty, not known.
  std::span<const Vec3> scanners;
  FillOptions fill;
  /// Default: false, leaves out no-data values, several points at exactly (0, 0, 0), and strays:
  /// points too far from the whole scan. `Reconstruction::dropped` counts them.
  bool keep_strays = false;
  /// Number of threads. The result does not depend on it. Default: 0, the calling TBB arena.
  int threads = 0;
  /// Called whenever a stage begins, with its name and the share of the stages that are done:
  /// "measure", "sort", "normals", "orient", "reconstruct", "fill". All calls come from one thread.
  /// An exception of the callback ends the reconstruction and reaches the caller. Default: empty.
  std::function<void(std::string_view stage, double done)> progress;
  /// Looked at every few milliseconds; has to outlive the call. Default: null, runs to the end.
  const StopToken* stop = nullptr;
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
/// the width that `cloud.schema.normal_type` says. Holds some 400 bytes per point, of fewer than
/// 2^32 points. Throws Error: usage for options out of range and for columns of a cloud that do not
/// belong together, bad input where no triangle can be formed or where coordinates span so many
/// decades that they are no scan's, interrupted when `options.stop` is requested; std::bad_alloc
/// passes through.
///
/// Thread-safe: several threads may call it at once. Changes no global state.
Reconstruction reconstruct(PointCloud cloud, const ReconstructionOptions& options = {});

/// The same for points that the caller keeps: copies them once, into the canonical order (once more
/// where some are left out). `normals` is as long as `positions` or empty; taken as doubles.
Reconstruction reconstruct(std::span<const Vec3> positions, std::span<const Vec3> normals,
                           const ReconstructionOptions& options = {});

}  // namespace orbweave
