#include "engine/voronoi/poles.h"
#include "io/vec3_order.h"

#include <algorithm>
#include <tuple>

namespace orbweave::voronoi {
namespace {

/// The farthest centre seen so far from each point; between equals the coordinates decide, so that
/// the order of the tetrahedra does not.
class Farthest {
 public:
  Farthest(const Tetrahedra& tetrahedra, std::vector<std::uint32_t>& cells)
      : tetrahedra_(tetrahedra), cells_(cells), distances_(cells.size(), 0.0) {}

  bool is_beyond(std::uint32_t cell, std::uint32_t p) const {
    const double radius = tetrahedra_.radii[cell], known = distances_[p];
    return radius >= known && (radius > known || wins_tie(cell, p));
  }
  void set(std::uint32_t cell, std::uint32_t p) {
    cells_[p] = cell;
    distances_[p] = tetrahedra_.radii[cell];
  }

 private:
  bool wins_tie(std::uint32_t cell, std::uint32_t p) const {
    if (cells_[p] == kNone) return true;
    const Vec3 a = tetrahedra_.centers[cell], b = tetrahedra_.centers[cells_[p]];
    return comes_before(b, a);
  }

  const Tetrahedra& tetrahedra_;
  std::vector<std::uint32_t>& cells_;
  std::vector<double> distances_;
};

/// The normal of a facet of the hull at one of its corners.
struct HullNormal {
  std::uint32_t point = 0;
  Vec3 normal;
};

/// The normals at points of the hull, in an order that the storage does not decide.
std::vector<HullNormal> hull_normals(const Tetrahedra& tetrahedra, std::vector<std::uint32_t>& at) {
  std::vector<HullNormal> normals;
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (tetrahedra.is_finite(c)) continue;
    for (const std::uint32_t p : tetrahedra.vertices[c]) {
      if (p == kInfinite) continue;
      at[p] = c;
      normals.push_back({p, tetrahedra.centers[c]});
    }
  }
  std::sort(normals.begin(), normals.end(), [](const HullNormal& a, const HullNormal& b) {
    return std::tie(a.point, a.normal.x, a.normal.y, a.normal.z) <
           std::tie(b.point, b.normal.x, b.normal.y, b.normal.z);
  });
  return normals;
}

/// The mean normals of the hull's facets at its points.
void set_hull_normals(const Tetrahedra& tetrahedra, Poles& poles) {
  const std::vector<HullNormal> normals = hull_normals(tetrahedra, poles.first);
  for (std::size_t i = 0; i < normals.size();) {
    const std::uint32_t p = normals[i].point;
    Vec3 sum;
    for (; i < normals.size() && normals[i].point == p; ++i) sum = sum + normals[i].normal;
    poles.normals[p] = normalized(sum);
  }
}

/// Calls visit(tetrahedron, point) for the corners of all finite tetrahedra, in the order of
/// storage: what is known of a point is nearer in memory than all the tetrahedra around it.
template <class Visit>
void visit_corners(const Tetrahedra& tetrahedra, const StopToken* stop, const Visit& visit) {
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (c % kStopBlock == 0) check_stop(stop);
    if (!tetrahedra.is_finite(c)) continue;
    for (const std::uint32_t p : tetrahedra.vertices[c]) visit(c, p);
  }
}

}  // namespace

Poles find_poles(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                 const StopToken* stop) {
  Poles poles;
  poles.normals.resize(points.size());
  poles.first.assign(points.size(), kNone);
  poles.second.assign(points.size(), kNone);
  Farthest first(tetrahedra, poles.first);
  visit_corners(tetrahedra, stop, [&](std::uint32_t cell, std::uint32_t p) {
    if (first.is_beyond(cell, p)) first.set(cell, p);
  });
  for (std::uint32_t p = 0; p < points.size(); ++p)
    if (poles.first[p] != kNone)
      poles.normals[p] = normalized(tetrahedra.centers[poles.first[p]] - points[p]);
  set_hull_normals(tetrahedra, poles);
  Farthest second(tetrahedra, poles.second);
  visit_corners(tetrahedra, stop, [&](std::uint32_t cell, std::uint32_t p) {
    if (second.is_beyond(cell, p) &&
        dot(tetrahedra.centers[cell] - points[p], poles.normals[p]) < 0.0)
      second.set(cell, p);
  });
  return poles;
}

}  // namespace orbweave::voronoi
