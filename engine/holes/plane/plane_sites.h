// Which of the gathered vertices shape a patch over the hole's plane.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/holes/patch/rim.h"
#include "engine/holes/plane/hole_frame.h"
#include "engine/holes/plane/plane_outline.h"
#include "engine/holes/problem/hole.h"

namespace orbweave {

struct PlaneSites {
  std::vector<std::uint32_t> vertices;  ///< of the problem; the rim's first, each once
  std::vector<Vec3> places;             ///< in the frame: plane coordinates and height
  std::uint32_t rim = 0;                ///< number of sites on the rim
};

/// The rim's vertices, and from there outward those that the sheet's faces reach without turning
/// over: upright, outside of the loop, not above or below another one. Beyond a few spacings from
/// the rim they are thinned, the more the further: what is left gives the same patch as all.
PlaneSites plane_sites(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
                       const PlaneOutline& outline);

/// At most `most` sites that stand for all: means over the sites nearest to places that are spread
/// evenly. For values with noise, which means have less of. O(n most).
std::vector<Vec3> mean_places(const std::vector<Vec3>& places, std::uint32_t most);

}  // namespace orbweave
