#include "engine/holes/rbf/bending_energy.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

namespace orbweave {
namespace {

/// A side of a triangle, by the larger end of its edge.
struct Side {
  std::uint32_t high = 0;
  std::uint32_t face = 0;
  friend auto operator<=>(const Side&, const Side&) = default;
};

/// The sides of triangles by the smaller ends of their edges, then sorted.
class Sides {
 public:
  Sides(std::span<const Triangle> patch, std::span<const Triangle> rim_faces, std::size_t vertices)
      : first_(vertices + 1, 0) {
    for_each(patch, rim_faces, [&](std::uint32_t low, Side) { ++first_[low + 1]; });
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    sides_.resize(first_.back());
    std::vector<std::uint32_t> place(first_.begin(), first_.end() - 1);
    for_each(patch, rim_faces, [&](std::uint32_t low, Side side) { sides_[place[low]++] = side; });
    for (std::size_t v = 0; v < vertices; ++v)
      std::sort(sides_.begin() + first_[v], sides_.begin() + first_[v + 1]);
  }

  std::span<const Side> at(std::uint32_t low) const {
    return std::span(sides_).subspan(first_[low], first_[low + 1] - first_[low]);
  }

 private:
  template <class Visit>
  static void for_each(std::span<const Triangle> patch, std::span<const Triangle> rim_faces,
                       const Visit& visit) {
    std::uint32_t face = 0;
    for (const std::span<const Triangle> triangles : {patch, rim_faces}) {
      for (const Triangle& t : triangles) {
        for (int k = 0; k < 3; ++k) {
          const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
          visit(low, Side{high, face});
        }
        ++face;
      }
    }
  }

  std::vector<std::uint32_t> first_;  // per vertex, and one past the last
  std::vector<Side> sides_;
};

}  // namespace

std::vector<Triangle> faces_at_rim(const HoleProblem& problem) {
  std::vector<std::uint8_t> on_rim(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) on_rim[v] = 1;
  std::vector<Triangle> faces;
  for (const Triangle& t : problem.sheet)
    if (on_rim[t[0]] + on_rim[t[1]] + on_rim[t[2]] >= 2) faces.push_back(t);
  return faces;
}

double bending_energy(const HoleProblem& problem, const HolePatch& patch) {
  return bending_energy(problem, faces_at_rim(problem), patch);
}

double bending_energy(const HoleProblem& problem, std::span<const Triangle> rim_faces,
                      const HolePatch& patch) {
  std::vector<Vec3> areas;  // as vectors, doubled
  areas.reserve(patch.triangles.size() + rim_faces.size());
  for (const std::span<const Triangle> triangles : {std::span(patch.triangles), rim_faces})
    for (const Triangle& t : triangles) areas.push_back(doubled_area(problem, patch, t));
  const std::size_t vertices = problem.positions.size() + patch.positions.size();
  const Sides sides(patch.triangles, rim_faces, vertices);
  double energy = 0.0;
  for (std::uint32_t low = 0; low < vertices; ++low) {
    const std::span<const Side> at_low = sides.at(low);
    for (std::size_t i = 0; i + 1 < at_low.size(); ++i) {
      const Side &first = at_low[i], &second = at_low[i + 1];
      if (first.high != second.high || first.face >= patch.triangles.size()) continue;
      const Vec3 a = areas[first.face], b = areas[second.face];
      const double area = 0.5 * (norm(a) + norm(b));
      if (!(area > 0.0)) continue;
      const double angle = std::atan2(norm(cross(a, b)), dot(a, b));
      energy +=
          3.0 * angle * angle *
          squared_norm(position_of(problem, patch, first.high) - position_of(problem, patch, low)) /
          area;
    }
  }
  return energy;
}

}  // namespace orbweave
