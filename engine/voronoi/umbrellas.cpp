#include "engine/voronoi/umbrellas.h"

#include <limits>

namespace orbweave::voronoi {

Umbrellas::Umbrellas(std::span<const Vec3> points, const Tetrahedra& tetrahedra, StarFinder& stars,
                     std::span<const Vec3> normals, const FacetFlags& flags)
    : points_(points), tetrahedra_(tetrahedra), stars_(stars), normals_(normals), flags_(flags) {}

/// Of the tetrahedron's centre above the tangent plane; those at infinity lie higher than all.
double Umbrellas::height(std::uint32_t p, std::uint32_t cell) const {
  const Vec3 center = tetrahedra_.centers[cell];
  if (tetrahedra_.is_finite(cell)) return dot(center - points_[p], normals_[p]);
  return dot(center, normals_[p]) * std::numeric_limits<double>::max();
}

bool Umbrellas::separate(std::uint32_t p) {
  const std::span<const std::uint32_t> star = stars_.find(p);
  sides_.assign(star.size(), UmbrellaSide::kNeither);
  if (star.empty()) return false;
  std::uint32_t top = star.front(), bottom = star.front();
  double highest = height(p, top), lowest = highest;
  for (std::uint32_t i = 0; i < star.size(); ++i) {
    const double here = height(p, star[i]);
    if (here > highest) highest = here, top = star[i];
    if (here < lowest) lowest = here, bottom = star[i];
  }
  return highest > 0.0 && lowest < 0.0 && flood(p, top, UmbrellaSide::kAbove) &&
         flood(p, bottom, UmbrellaSide::kBelow);
}

/// False where the flood reaches what another one has reached.
bool Umbrellas::flood(std::uint32_t p, std::uint32_t from, UmbrellaSide side) {
  if (sides_[stars_.place(from)] != UmbrellaSide::kNeither) return false;
  sides_[stars_.place(from)] = side;
  waiting_.assign(1, from);
  while (!waiting_.empty()) {
    const std::uint32_t cell = waiting_.back();
    waiting_.pop_back();
    for (int place = 0; place < 4; ++place) {
      const auto at = static_cast<std::size_t>(place);
      if (tetrahedra_.vertices[cell][at] == p || flags_.has({cell, place})) continue;
      const std::uint32_t next = tetrahedra_.neighbors[cell][at];
      UmbrellaSide& there = sides_[stars_.place(next)];
      if (there == side) continue;
      if (there != UmbrellaSide::kNeither) return false;
      there = side;
      waiting_.push_back(next);
    }
  }
  return true;
}

}  // namespace orbweave::voronoi
