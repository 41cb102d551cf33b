// Ball pivoting's result as any triangles have it: for methods that find triangles alone.
#pragma once

#include <span>
#include <vector>

#include "engine/ball_pivoting/pivoting_result.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// Turns components of triangles, linked over edges, so that they agree with the normals of their
/// vertices more than they oppose them. No directed edge may have two triangles. A component
/// without normals stays as it is.
void turn_to_normals(std::span<const Vec3> positions, std::span<const Vec3> normals,
                     std::vector<Triangle>& triangles, const StopToken* stop = nullptr);

/// The fans at `points` vertices of triangles that have no directed edge twice. Triangles come
/// sorted, smallest vertex first, all owned. O(n) for bounded vertex degrees.
BallPivotingResult with_fans(std::vector<Triangle> triangles, std::size_t points,
                             const StopToken* stop = nullptr);

}  // namespace orbweave
