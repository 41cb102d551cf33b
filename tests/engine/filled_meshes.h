// Meshes with holes, and what has to hold of what the fill makes of them.
#pragma once

#include <cstddef>
#include <functional>

#include "engine/holes/fill_mesh.h"
#include "io/triangle_mesh.h"

namespace orbweave::test {

/// Whatever the hole: the given part stays as it was, and what is added is sound.
void require_sound(const TriangleMesh& before, const FilledMesh& filled);
/// The same, and nothing is open.
void require_closed(const TriangleMesh& before, const FilledMesh& filled);

std::size_t count_filled(const FilledMesh& filled);
/// Largest |distance(new vertex)|.
double farthest_new_vertex(const TriangleMesh& before, const FilledMesh& filled,
                           const std::function<double(Vec3)>& distance);

/// From the unit sphere about the origin.
double off_sphere(Vec3 p);
/// Of radius 1 around z, from z = 0 up, open at both ends.
TriangleMesh tube(double length);

}  // namespace orbweave::test
