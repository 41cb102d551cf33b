#include "engine/pipeline/surface/filled_boundary.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "engine/geometry/disjoint_sets.h"
#include "engine/stitching/mesh_summary.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

constexpr auto by_vertex = [](const OpenFan& a, const OpenFan& b) {
  return a.vertex != b.vertex ? a.vertex < b.vertex : a.previous < b.previous;
};

/// Joins fans of one vertex, [first, last) by what is before them, where one ends at the edge at
/// which another begins; those that close vanish. Returns the end of what is left.
OpenFan* join_at_vertex(OpenFan* first, OpenFan* last) {
  const auto n = static_cast<std::size_t>(last - first);
  const auto after = [&](const OpenFan& fan) {
    const OpenFan* at = std::lower_bound(
        first, last, fan.next,
        [](const OpenFan& other, std::uint64_t previous) { return other.previous < previous; });
    return at != last && at->previous == fan.next ? static_cast<std::size_t>(at - first) : n;
  };
  std::vector<std::size_t> next(n);
  std::vector<std::uint8_t> has_before(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    next[i] = after(first[i]);
    if (next[i] < n) has_before[next[i]] = 1;
  }
  std::vector<OpenFan> left;
  for (std::size_t i = 0; i < n; ++i) {
    if (has_before[i] != 0) continue;
    std::size_t end = i;
    while (next[end] < n) end = next[end];
    left.push_back({first[i].previous, first[i].vertex, first[end].next, first[i].component});
  }
  return std::copy(left.begin(), left.end(), first);
}

/// The boundary of fans of the mesh and of patches together.
void join_fans(std::vector<OpenFan>& fans) {
  std::sort(fans.begin(), fans.end(), by_vertex);
  std::size_t kept = 0;
  for (std::size_t begin = 0, end = 0; begin < fans.size(); begin = end) {
    while (end < fans.size() && fans[end].vertex == fans[begin].vertex) ++end;
    std::size_t last = end;
    if (end - begin > 1) {
      const OpenFan* left = join_at_vertex(fans.data() + begin, fans.data() + end);
      last = static_cast<std::size_t>(left - fans.data());
    }
    for (std::size_t i = begin; i < last; ++i) fans[kept++] = fans[i];
  }
  fans.resize(kept);
}

/// The fans with doubled vertices under their own numbers.
std::vector<OpenFan> in_split_numbers(std::vector<OpenFan> fans,
                                      std::span<const SplitCorner> splits) {
  struct Renamed {
    Triangle64 end;  // (tail, head, one of the two)
    std::uint64_t number;
  };
  std::vector<Renamed> numbers;
  numbers.reserve(2 * splits.size());
  constexpr std::uint64_t kCopies = std::uint64_t{1} << 62;
  for (const SplitCorner& split : splits) {
    const Triangle64& t = split.triangle;
    const int k = t[0] == split.vertex ? 0 : t[1] == split.vertex ? 1 : 2;
    numbers.push_back({{t[k], t[(k + 1) % 3], split.vertex}, kCopies + value_of(split.copy)});
    numbers.push_back({{t[(k + 2) % 3], t[k], split.vertex}, kCopies + value_of(split.copy)});
  }
  if (numbers.empty()) return fans;
  std::sort(numbers.begin(), numbers.end(),
            [](const Renamed& a, const Renamed& b) { return a.end < b.end; });
  const auto renamed = [&](std::uint64_t tail, std::uint64_t head, std::uint64_t vertex) {
    const Triangle64 end{tail, head, vertex};
    const auto at =
        std::lower_bound(numbers.begin(), numbers.end(), end,
                         [](const Renamed& known, const Triangle64& e) { return known.end < e; });
    return at != numbers.end() && at->end == end ? at->number : vertex;
  };
  constexpr std::size_t kFansAtOnce = 4096;
  for_each_whole((fans.size() + kFansAtOnce - 1) / kFansAtOnce, [&](std::size_t block) {
    const std::size_t begin = block * kFansAtOnce;
    for (OpenFan& fan : std::span(fans).subspan(begin, std::min(kFansAtOnce, fans.size() - begin)))
      fan = {renamed(fan.previous, fan.vertex, fan.previous),
             renamed(fan.vertex, fan.next, fan.vertex), renamed(fan.vertex, fan.next, fan.next),
             fan.component};
  });
  return fans;
}

/// Per loop, whether the patch that closes it is one of those that were stored first.
std::vector<std::uint8_t> closed_loops(std::span<const HoleFacts> holes, const Mended& mended,
                                       std::size_t loops) {
  std::vector<std::uint8_t> closed(loops, 0);
  for (std::size_t l = 0; l < loops; ++l) {
    const bool is_replaced = !mended.is_replaced.empty() && mended.is_replaced[l] != 0;
    closed[l] = holes[l].filled && holes[l].open_edges == 0 && !is_replaced ? 1 : 0;
  }
  return closed;
}

/// Adds the fans of patches that close their loops: one per corner, from the edge at which the
/// mesh's next fan around begins to the one at which the last one ended.
void add_fans_of_closed(std::span<const BoundaryLoop> loops, std::span<const std::uint8_t> closed,
                        std::vector<OpenFan>& fans) {
  std::size_t corners = 0;
  for (std::size_t l = 0; l < loops.size(); ++l)
    corners += closed[l] != 0 ? loops[l].vertices.size() : 0;
  fans.reserve(fans.size() + corners);
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (closed[l] == 0) continue;
    const std::vector<std::uint64_t>& loop = loops[l].vertices;
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i)
      fans.push_back({loop[i], loop[(i + 1) % n], loop[(i + 2) % n], 0});
  }
}

/// Adds the fans of triangles as they lie at their vertices, each triangle one: they are joined
/// with the others.
void add_fans_of(std::span<const Triangle64> triangles, std::vector<OpenFan>& fans) {
  fans.reserve(fans.size() + 3 * triangles.size());
  for (const Triangle64& t : triangles)
    for (int k = 0; k < 3; ++k) fans.push_back({t[(k + 2) % 3], t[k], t[(k + 1) % 3], 0});
}

/// Fans of the mesh have changed where it was mended.
void add_mended_corners(const Mended& mended, std::vector<OpenFan>& fans) {
  std::erase_if(fans, [&](const OpenFan& fan) {
    return std::binary_search(mended.touched.begin(), mended.touched.end(), fan.vertex);
  });
  fans.insert(fans.end(), mended.corners.begin(), mended.corners.end());
}

/// Joins the pieces of the mesh that patches hold together. `fans`: of the mesh, by vertex.
void unite_over(std::span<const Triangle64> triangles, std::span<const OpenFan> fans,
                DisjointSets& pieces) {
  struct Side {
    std::array<std::uint64_t, 2> edge;
    std::uint32_t triangle;
    auto operator<=>(const Side&) const = default;
  };
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) sides.push_back({{triangles[t][k], triangles[t][(k + 1) % 3]}, t});
  std::sort(sides.begin(), sides.end());
  const auto first = static_cast<std::uint32_t>(pieces.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) pieces.add();
  for (const Side& side : sides) {
    const auto other =
        std::lower_bound(sides.begin(), sides.end(), Side{{side.edge[1], side.edge[0]}, 0});
    if (other != sides.end() && other->edge[0] == side.edge[1] && other->edge[1] == side.edge[0])
      pieces.unite(first + side.triangle, first + other->triangle);
    // The mesh has the edge the other way round: its fan at the tail begins with it.
    const auto fan = std::lower_bound(fans.begin(), fans.end(),
                                      OpenFan{side.edge[1], side.edge[0], 0, 0}, by_vertex);
    if (fan != fans.end() && fan->vertex == side.edge[0] && fan->previous == side.edge[1])
      pieces.unite(first + side.triangle, static_cast<std::uint32_t>(fan->component));
  }
}

/// Connected pieces once patches join them, without those that are removed. A patch within one
/// piece joins nothing.
std::uint64_t count_components(const UnfilledMesh& mesh, const PatchTotals& patches) {
  DisjointSets pieces(mesh.pieces.size());
  unite_over(patches.open_triangles, mesh.fans, pieces);
  unite_over(patches.joining_triangles, mesh.fans, pieces);
  std::uint64_t components = 0;
  for (std::uint32_t p = 0; p < mesh.pieces.size(); ++p) {
    components += pieces.find(p) == p ? 1 : 0;
    components -= mesh.is_removed[p];
  }
  return components - mesh.mended.pieces_gone;
}

/// Vertices that were doubled.
std::uint64_t count_pinches(const FilledHoles& filled) {
  std::vector<std::uint64_t> doubled = filled.copies;
  std::sort(doubled.begin(), doubled.end());
  return static_cast<std::uint64_t>(std::unique(doubled.begin(), doubled.end()) - doubled.begin());
}

}  // namespace

MeshFacts facts_after_fill(MeshFacts facts, UnfilledMesh mesh, std::vector<BoundaryLoop> loops,
                           const FilledHoles& filled, const PatchTotals& patches) {
  for (const HoleFacts& hole : filled.holes) {
    if (!hole.filled) continue;
    facts.vertices += hole.points_added;
    facts.triangles += hole.triangles_added;
  }
  std::vector<OpenFan>& fans = mesh.fans;
  tbb::parallel_sort(fans.begin(), fans.end(), by_vertex);
  facts.components = count_components(mesh, patches);
  add_mended_corners(mesh.mended, fans);
  add_fans_of_closed(loops, closed_loops(filled.holes, mesh.mended, loops.size()), fans);
  loops = {};
  add_fans_of(patches.open_triangles, fans);
  add_fans_of(patches.mended_triangles, fans);
  join_fans(fans);
  facts.vertices += filled.copies.size();
  facts.vertices -= filled.freed.size();
  facts.triangles -= filled.removed.size();
  facts.nonmanifold_vertices = 0;
  facts.pinches = count_pinches(filled);
  facts.mended_triangles = mesh.mended.taken.size() + filled.flaps;
  facts.area += patches.area;
  // What was taken away leaves the rounding of a sum.
  if (facts.triangles == 0) facts.area = 0.0;
  facts.patch_area = patches.area;
  facts.boundary_edges = fans.size();
  facts.boundary_loops = count_loops(in_split_numbers(std::move(fans), filled.splits));
  derive_facts(facts);
  return facts;
}

}  // namespace orbweave
