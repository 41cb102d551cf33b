// The mesh of a tile: what its faces carry as attributes of vertices.
#pragma once

#include <string>
#include <vector>

#include "engine/levels/node_mesh.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// What the faces of the whole mesh have.
struct TileColumns {
  bool has_holes = false;       ///< any face fills a hole
  bool has_confidence = false;  ///< faces that do say how sure the patch is
  bool has_components = false;  ///< there is more than one
};

/// Attributes that the mesh of a tile has: "component" where there are components, "hole" and
/// "confidence" where any of its faces fills a hole.
std::vector<std::string> tile_attributes(const NodeMesh& mesh, const TileColumns& columns);

/// The mesh of a node with these attributes, as floats. All corners of a face have what the face
/// has: a vertex whose faces differ comes once for each of the values, the first time at its place,
/// further times behind all others, in the order of the triangles.
TriangleMesh tile_mesh(const PointCloud& points, const NodeMesh& mesh, const TileColumns& columns);

}  // namespace orbweave
