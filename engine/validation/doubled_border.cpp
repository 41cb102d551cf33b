#include "engine/validation/doubled_border.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "engine/validation/edge_table.h"
#include "io/vec3_order.h"

namespace orbweave {
namespace {

using Way = std::array<Vec3, 2>;  ///< from one place to another

bool runs_before(const Way& a, const Way& b) {
  return a[0] == b[0] ? comes_before(a[1], b[1]) : comes_before(a[0], b[0]);
}

/// The boundary edges as their triangles run along them, but those without a length.
std::vector<Way> border_ways(const TriangleMesh& mesh) {
  std::vector<Way> ways;
  const EdgeTable table(mesh.triangles, mesh.vertices.size());
  table.for_each_edge(
      [&](std::uint32_t lower, std::uint32_t upper, std::span<const EdgeTable::Use> uses) {
        const Vec3 a = mesh.vertices.positions[lower], b = mesh.vertices.positions[upper];
        if (uses.size() != 1 || a == b || !is_finite(a) || !is_finite(b)) return;
        const bool is_forward = runs_along(mesh.triangles[uses[0].triangle], lower, upper);
        ways.push_back(is_forward ? Way{a, b} : Way{b, a});
      });
  return ways;
}

}  // namespace

std::uint64_t count_doubled_border(const TriangleMesh& mesh) {
  std::vector<Way> ways = border_ways(mesh);
  std::sort(ways.begin(), ways.end(), runs_before);
  return static_cast<std::uint64_t>(std::ranges::count_if(ways, [&](const Way& way) {
    return std::binary_search(ways.begin(), ways.end(), Way{way[1], way[0]}, runs_before);
  }));
}

}  // namespace orbweave
