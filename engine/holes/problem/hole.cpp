#include "engine/holes/problem/hole.h"

namespace orbweave {

const char* name_of(FillMethod method) {
  switch (method) {
    case FillMethod::kDirect:
      return "direct";
    case FillMethod::kPlane:
      return "plane";
    case FillMethod::kImplicit:
      return "implicit";
    case FillMethod::kCreased:
      return "creased";
    case FillMethod::kNone:
      break;
  }
  return "none";
}

double rim_spacing(const HoleProblem& problem) {
  const std::size_t edges = problem.loop.size();
  if (edges == 0) return 0.0;
  double perimeter = 0.0;
  for (std::size_t i = 0; i < edges; ++i) {
    const Vec3 from = problem.positions[problem.loop[i]];
    perimeter += norm(problem.positions[problem.loop[(i + 1) % edges]] - from);
  }
  return perimeter / static_cast<double>(edges);
}

double area_of(const HoleProblem& problem, const HolePatch& patch) {
  double area = 0.0;
  for (const Triangle& t : patch.triangles) area += 0.5 * norm(doubled_area(problem, patch, t));
  return area;
}

}  // namespace orbweave
