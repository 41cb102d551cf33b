#include "engine/validation/usable_triangles.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace orbweave {
namespace {

enum class Fault : std::uint8_t { kNone, kDegenerate, kRepeated, kNotFinite };

Fault fault_of(const Triangle& t, const std::vector<Vec3>& at) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return Fault::kDegenerate;
  for (const std::uint32_t vertex : t) {
    const Vec3 p = at[vertex];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return Fault::kNotFinite;
  }
  return Fault::kNone;
}

/// Vertices in ascending order, then the triangle's number: the first of equal ones stays.
using NumberedTriangle = std::array<std::uint32_t, 4>;

void mark_repeated(const TriangleMesh& mesh, std::vector<Fault>& faults) {
  std::vector<NumberedTriangle> sorted;
  sorted.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (faults[i] != Fault::kNone) continue;
    Triangle t = mesh.triangles[i];
    std::ranges::sort(t);
    sorted.push_back({t[0], t[1], t[2], static_cast<std::uint32_t>(i)});
  }
  std::ranges::sort(sorted);
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin()))
      faults[sorted[i][3]] = Fault::kRepeated;
}

}  // namespace

UnusableTriangles remove_unusable_triangles(TriangleMesh& mesh) {
  std::vector<Fault> faults;
  faults.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) faults.push_back(fault_of(t, mesh.vertices.positions));
  mark_repeated(mesh, faults);
  UnusableTriangles removed;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < faults.size(); ++i) {
    removed.degenerate += faults[i] == Fault::kDegenerate;
    removed.repeated += faults[i] == Fault::kRepeated;
    removed.not_finite += faults[i] == Fault::kNotFinite;
    if (faults[i] != Fault::kNone) continue;
    mesh.triangles[kept] = mesh.triangles[i];
    if (!mesh.hole.empty()) mesh.hole[kept] = mesh.hole[i];
    ++kept;
  }
  mesh.triangles.resize(kept);
  if (!mesh.hole.empty()) mesh.hole.resize(kept);
  return removed;
}

}  // namespace orbweave
