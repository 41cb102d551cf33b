// Vertex normals from a mesh's faces: how a mesh becomes an oriented cloud.
#pragma once

#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// One unit normal per vertex: the sum of its faces' normals weighted by their areas. A vertex
/// that no face uses, or whose faces cancel, takes the normal of the nearest vertex that has one
/// (of equally near ones the first). All zero where no face has an area; zero at a vertex that is
/// not finite. Differences of coordinates are taken first, so a mesh far from the origin loses
/// nothing. Throws Error (bad input) for indices outside the vertices. O(n) plus a search per
/// vertex left out.
std::vector<Vec3> normals_from_faces(const TriangleMesh& mesh);

}  // namespace orbweave
