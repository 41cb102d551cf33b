// The classes of the module: clouds, meshes, holes.
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

#include "io/hole_facts.h"
#include "io/points/dropped_points.h"
#include "io/triangle_mesh.h"

namespace orbweave::python {

struct CloudObject {
  PointCloud cloud;
  std::string coordinate_system;
};

/// A mesh and, where it was reconstructed, what is known of it.
struct MeshObject {
  TriangleMesh mesh;
  std::vector<HoleFacts> holes;
  std::vector<double> ball_radii;
  DroppedPoints dropped;
  std::string coordinate_system;
};

void add_objects(pybind11::module_& module);

}  // namespace orbweave::python
