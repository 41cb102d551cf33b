#include "engine/validation/mesh_crossings.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "engine/geometry/crossing_pairs.h"

namespace orbweave {
namespace {

/// Per vertex the first one in its place.
std::vector<std::uint32_t> first_in_place(const std::vector<Vec3>& positions) {
  std::vector<std::uint32_t> order(positions.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto before = [&](std::uint32_t a, std::uint32_t b) {
    const Vec3 p = positions[a], q = positions[b];
    if (p.x != q.x) return p.x < q.x;
    if (p.y != q.y) return p.y < q.y;
    return p.z != q.z ? p.z < q.z : a < b;
  };
  std::sort(order.begin(), order.end(), before);
  std::vector<std::uint32_t> first(positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && positions[order[i]] == positions[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

}  // namespace

std::uint64_t count_crossing_pairs(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> first = first_in_place(mesh.vertices.positions);
  std::vector<Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const Triangle placed = {first[t[0]], first[t[1]], first[t[2]]};
    const bool is_flat = placed[0] == placed[1] || placed[1] == placed[2] || placed[2] == placed[0];
    const bool is_there = std::ranges::all_of(
        t, [&](std::uint32_t v) { return is_finite(mesh.vertices.positions[v]); });
    if (is_there && !is_flat) triangles.push_back(placed);
  }
  return crossing_pairs(mesh.vertices.positions, triangles).size();
}

}  // namespace orbweave
