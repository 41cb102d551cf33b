#include "engine/holes/patch/folded_patch.h"

namespace orbweave {
namespace {

/// Calls visit(twice the area of a triangle, whether it is folded).
template <class Visit>
void for_each_triangle(const HoleProblem& problem, const HolePatch& patch, const Visit& visit) {
  constexpr double kFacesAway = -0.5;  // cosine
  const std::size_t given = problem.positions.size();
  const auto at = [&](std::uint32_t v) {
    return v < given ? problem.positions[v] : patch.positions[v - given];
  };
  for (const Triangle& t : patch.triangles) {
    const Vec3 a = at(t[0]);
    const Vec3 area = cross(at(t[1]) - a, at(t[2]) - a);
    Vec3 sheet;
    for (const std::uint32_t v : t)
      if (v < given) sheet = sheet + problem.normals[v];
    const double size = norm(area);
    visit(size, dot(area, normalized(sheet)) < kFacesAway * size);
  }
}

}  // namespace

double folded_share(const HoleProblem& problem, const HolePatch& patch) {
  double folded = 0.0, all = 0.0;
  for_each_triangle(problem, patch, [&](double size, bool is_folded) {
    all += size;
    if (is_folded) folded += size;
  });
  return all > 0.0 ? folded / all : 0.0;
}

bool is_folded(const HoleProblem& problem, const HolePatch& patch) {
  constexpr double kMostFolded = 0.1;
  return folded_share(problem, patch) > kMostFolded;
}

}  // namespace orbweave
