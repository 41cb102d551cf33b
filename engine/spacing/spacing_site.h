// Where the distances between the points of a cloud are measured.
#pragma once

#include <vector>

#include "io/box.h"
#include "io/vec3.h"

namespace orbweave {

/// A place where distances are measured: at the points in `core`, among all points of the cloud in
/// the larger `box`, both closed; in any order, duplicates included.
struct SpacingSite {
  Box core;
  Box box;
  std::vector<Vec3> points;
};

}  // namespace orbweave
