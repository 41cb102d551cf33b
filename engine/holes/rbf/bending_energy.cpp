#include "engine/holes/rbf/bending_energy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace orbweave {
namespace {

/// A side of a triangle, by its edge.
struct Side {
  std::array<std::uint32_t, 2> edge{};
  std::uint32_t face = 0;
  friend auto operator<=>(const Side&, const Side&) = default;
};

void add_sides(const Triangle& t, std::uint32_t face, std::vector<Side>& sides) {
  for (int k = 0; k < 3; ++k) {
    const std::uint32_t a = t[k], b = t[(k + 1) % 3];
    sides.push_back({{std::min(a, b), std::max(a, b)}, face});
  }
}

/// The patch's triangles and those of the sheet that have two vertices on the rim at least.
std::vector<Triangle> patch_and_rim(const HoleProblem& problem, const HolePatch& patch) {
  std::vector<std::uint8_t> on_rim(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) on_rim[v] = 1;
  std::vector<Triangle> triangles = patch.triangles;
  for (const Triangle& t : problem.sheet) {
    if (on_rim[t[0]] + on_rim[t[1]] + on_rim[t[2]] >= 2) triangles.push_back(t);
  }
  return triangles;
}

}  // namespace

double bending_energy(const HoleProblem& problem, const HolePatch& patch) {
  const std::size_t given = problem.positions.size();
  const auto at = [&](std::uint32_t v) {
    return v < given ? problem.positions[v] : patch.positions[v - given];
  };
  const std::vector<Triangle> triangles = patch_and_rim(problem, patch);
  std::vector<Vec3> areas;  // as vectors, doubled
  std::vector<Side> sides;
  for (const Triangle& t : triangles) {
    add_sides(t, static_cast<std::uint32_t>(areas.size()), sides);
    areas.push_back(cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0])));
  }
  std::sort(sides.begin(), sides.end());
  double energy = 0.0;
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const Side &first = sides[i], &second = sides[i + 1];
    if (first.edge != second.edge || first.face >= patch.triangles.size()) continue;
    const Vec3 a = areas[first.face], b = areas[second.face];
    const double area = 0.5 * (norm(a) + norm(b));
    if (!(area > 0.0)) continue;
    const double angle = std::atan2(norm(cross(a, b)), dot(a, b));
    energy += 3.0 * angle * angle * squared_norm(at(first.edge[1]) - at(first.edge[0])) / area;
  }
  return energy;
}

}  // namespace orbweave
