#include "engine/holes/patch/folded_patch.h"

namespace orbweave {

double folded_share(const HoleProblem& problem, const HolePatch& patch) {
  constexpr double kFacesAway = -0.5;  // cosine
  const std::size_t given = problem.positions.size();
  const auto at = [&](std::uint32_t v) {
    return v < given ? problem.positions[v] : patch.positions[v - given];
  };
  double folded = 0.0, all = 0.0;
  for (const Triangle& t : patch.triangles) {
    const Vec3 a = at(t[0]);
    const Vec3 area = cross(at(t[1]) - a, at(t[2]) - a);
    Vec3 sheet;
    for (const std::uint32_t v : t)
      if (v < given) sheet = sheet + problem.normals[v];
    const double size = norm(area);
    all += size;
    if (dot(area, normalized(sheet)) < kFacesAway * size) folded += size;
  }
  return all > 0.0 ? folded / all : 0.0;
}

bool is_folded(const HoleProblem& problem, const HolePatch& patch) {
  constexpr double kMostFolded = 0.05;
  return folded_share(problem, patch) > kMostFolded;
}

}  // namespace orbweave
