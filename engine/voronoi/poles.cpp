#include "engine/voronoi/poles.h"

#include <algorithm>
#include <tuple>

namespace orbweave::voronoi {
namespace {

/// Whether the centre of `a` is the farther one; between equals the coordinates decide, so that the
/// order of the tetrahedra does not.
bool is_farther(const Tetrahedra& tetrahedra, std::uint32_t a, std::uint32_t b) {
  if (b == kNone) return true;
  if (tetrahedra.radii[a] != tetrahedra.radii[b]) return tetrahedra.radii[a] > tetrahedra.radii[b];
  const Vec3 p = tetrahedra.centers[a], q = tetrahedra.centers[b];
  return std::tie(p.x, p.y, p.z) > std::tie(q.x, q.y, q.z);
}

/// Adds the normals of the hull's facets at a vertex, in an order that the storage does not decide.
Vec3 mean_normal(std::vector<Vec3>& facets) {
  std::sort(facets.begin(), facets.end(), [](const Vec3& a, const Vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  Vec3 sum;
  for (const Vec3 normal : facets) sum = sum + normal;
  return normalized(sum);
}

}  // namespace

Poles find_poles(std::span<const Vec3> points, const Tetrahedra& tetrahedra, const Stars& stars,
                 const StopToken* stop) {
  Poles poles;
  poles.normals.resize(points.size());
  poles.first.assign(points.size(), kNone);
  poles.second.assign(points.size(), kNone);
  std::vector<Vec3> facets;
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    if (p % kStopBlock == 0) check_stop(stop);
    std::uint32_t& first = poles.first[p];
    facets.clear();
    for (const std::uint32_t cell : stars.of(p)) {
      if (!tetrahedra.is_finite(cell)) {
        facets.push_back(tetrahedra.centers[cell]);
        first = cell;
      } else if (facets.empty() && is_farther(tetrahedra, cell, first)) {
        first = cell;
      }
    }
    if (first == kNone) continue;
    poles.normals[p] =
        facets.empty() ? normalized(tetrahedra.centers[first] - points[p]) : mean_normal(facets);
    for (const std::uint32_t cell : stars.of(p)) {
      if (!tetrahedra.is_finite(cell)) continue;
      if (dot(tetrahedra.centers[cell] - points[p], poles.normals[p]) < 0.0 &&
          is_farther(tetrahedra, cell, poles.second[p]))
        poles.second[p] = cell;
    }
  }
  return poles;
}

}  // namespace orbweave::voronoi
