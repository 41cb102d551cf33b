#include "engine/holes/patch/folded_patch.h"

namespace orbweave {

bool is_folded(const HoleProblem& problem, const HolePatch& patch) {
  constexpr double kFacesAway = -0.5;  // cosine
  constexpr double kMostFolded = 0.1;
  double folded = 0.0, all = 0.0;
  for (const Triangle& t : patch.triangles) {
    const Vec3 area = doubled_area(problem, patch, t);
    Vec3 sheet;
    for (const std::uint32_t v : t)
      if (v < problem.positions.size()) sheet = sheet + problem.normals[v];
    const double size = norm(area);
    all += size;
    if (dot(area, normalized(sheet)) < kFacesAway * size) folded += size;
  }
  return folded > kMostFolded * all;
}

}  // namespace orbweave
