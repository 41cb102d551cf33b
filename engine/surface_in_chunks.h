// Ball pivoting of a cloud in memory, chunk by chunk, as a job does it from its store.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// The triangles of ball_pivoting() for all points, with what the walk holds kept to chunks of
/// `chunk_points` points: the whole at once takes some 170 bytes per point more. Positions distinct
/// and in the canonical order of the root cube of their bounds. Goes over the whole at once where
/// the cloud is one chunk, or where halos would be large beside chunks. Runs on the calling TBB
/// arena. Throws as ball_pivoting().
std::vector<Triangle> triangles_in_chunks(std::span<const Vec3> positions,
                                          std::span<const Vec3> normals,
                                          const BallPivotingOptions& options,
                                          std::uint64_t chunk_points);

}  // namespace orbweave
