// The Power Crust of a job's points: a stage of its own, because the surface's vertices are not the
// points. They take the points' place in all stages that follow, with the attributes of the points
// near them.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "io/meshes/mesh_writer.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// The stage; its results are in the store. Returns the partition of the vertices: one chunk, in
/// canonical order, with normals from the faces and the attributes of each vertex's sample. What
/// was measured of the points stays as it was. Throws as voronoi::power_crust, and Error (resource)
/// where the points do not fit the budget.
Partition make_power_crust(const Partition& points, StageRunner& runner);

/// The triangles that the stage left, over the vertices of its chunk: turned to the normals of the
/// points, smallest vertex first, sorted, two at each edge.
std::vector<Triangle> load_power_crust(const ChunkStore& store);

/// The polygons that the triangles were cut from, turned likewise, smallest vertex first, sorted.
PolygonFaces load_polygons(const ChunkStore& store);

/// The inner balls of the medial axis, in the order of their centres' coordinates.
struct MedialAxis {
  std::vector<Vec3> centers;
  std::vector<double> radii;
};
MedialAxis load_medial_axis(const ChunkStore& store);

}  // namespace orbweave
