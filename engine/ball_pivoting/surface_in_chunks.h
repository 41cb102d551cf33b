// Ball pivoting of a cloud in memory, chunk by chunk, as a job does it from its store.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// The triangles of ball_pivoting() for all points. Only the chunks in work, of `chunk_points`
/// points at most, need the memory of the walk: some 180 bytes per point, measured. Positions are
/// distinct and in the canonical order of the root cube of their bounds. Small clouds and clouds
/// whose halos would be large beside their chunks are taken at once. Runs on the calling TBB arena.
/// Throws as ball_pivoting().
std::vector<Triangle> triangles_in_chunks(std::span<const Vec3> positions,
                                          std::span<const Vec3> normals,
                                          const BallPivotingOptions& options,
                                          std::uint64_t chunk_points);

}  // namespace orbweave
