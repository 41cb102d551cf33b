// Which of the gathered vertices shape a patch over the hole's plane.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/holes/hole.h"
#include "engine/holes/hole_frame.h"
#include "engine/holes/plane_outline.h"
#include "engine/holes/rim.h"

namespace orbweave {

struct PlaneSites {
  std::vector<std::uint32_t> vertices;  ///< of the problem; the rim's first, each once
  std::vector<Vec3> places;             ///< in the frame: plane coordinates and height
  std::uint32_t rim = 0;                ///< so many of them are the rim's
  std::string reason;                   ///< why there are none
};

/// The rim's vertices, and from there outward those that the sheet's faces reach without turning
/// over: upright, outside of the loop, not above or below another one. `most`: of them, the
/// nearest to the rim along the sheet.
PlaneSites plane_sites(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
                       const PlaneOutline& outline, std::uint32_t most);

}  // namespace orbweave
