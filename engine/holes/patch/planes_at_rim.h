// Whether a hole runs across an edge: the surface around it lies in two planes that meet at an
// angle (the ridge of a roof, the edge of a box), or in three (the corner of a box).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/holes/patch/face_planes.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

/// The planes in the order in which the rim runs through them, each once.
struct PlanesAtRim {
  std::vector<FittedPlane> planes;  ///< 2 or 3; relative to the rim's centre
  std::vector<std::uint32_t>
      anchors;  ///< per plane, the corner at which its part of the rim begins

  std::size_t before(std::size_t plane) const {
    return (plane + planes.size() - 1) % planes.size();
  }
};

/// Empty where the faces behind the rim are no such planes: where they lie further from them than
/// noise would have it or fit a smooth surface nearly as well, where planes meet at less than 20
/// degrees, or where the rim changes from one to the other anywhere but at their common line.
std::optional<PlanesAtRim> find_planes_at_rim(const HoleProblem& problem, const Rim& rim);

}  // namespace orbweave
