// Ball pivoting of a cloud in memory, chunk by chunk, as a job does it from its store.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "io/triangle_mesh.h"
#include "partition/octree.h"

namespace orbweave {

/// The triangles of ball_pivoting() for all points. Only the chunks in work need the memory of the
/// walk: some 180 bytes per point, measured. Positions are distinct and in the canonical order of
/// the octree's root cube. One chunk and chunks whose halos would be large beside them are taken at
/// once. Runs on the calling TBB arena. Throws as ball_pivoting().
std::vector<Triangle> triangles_in_chunks(std::span<const Vec3> positions,
                                          std::span<const Vec3> normals,
                                          const BallPivotingOptions& options, Octree octree);

}  // namespace orbweave
