#include "engine/pipeline/surface/filled_boundary.h"

#include <algorithm>
#include <array>
#include <utility>

#include "engine/geometry/disjoint_sets.h"
#include "engine/pipeline/surface/small_pieces.h"
#include "engine/stitching/mesh_summary.h"

namespace orbweave {
namespace {

/// Fans that are left. Where a patch fills the gap after a fan, it goes on with the next one.
/// `corners`: of filled loops, (arriving from, vertex, leaving to), sorted.
void close_fans(std::span<const Triangle64> corners, std::vector<OpenFan>& fans) {
  const auto filled_after = [&](std::uint64_t previous, std::uint64_t vertex) {
    const auto at =
        std::lower_bound(corners.begin(), corners.end(), Triangle64{previous, vertex, 0});
    const bool found = at != corners.end() && (*at)[0] == previous && (*at)[1] == vertex;
    return found ? &*at : nullptr;
  };
  using Edge = std::array<std::uint64_t, 2>;
  std::vector<Edge> begun;  // (vertex, next) of fans after a filled gap
  begun.reserve(corners.size());
  for (const Triangle64& corner : corners) begun.push_back({corner[1], corner[2]});
  std::sort(begun.begin(), begun.end());
  const auto is_begun = [&](const OpenFan& fan) {
    return std::binary_search(begun.begin(), begun.end(), Edge{fan.vertex, fan.next});
  };
  std::vector<Triangle64> gone;  // (vertex, next, previous) of those fans
  gone.reserve(begun.size());
  for (const OpenFan& fan : fans)
    if (is_begun(fan)) gone.push_back({fan.vertex, fan.next, fan.previous});
  std::sort(gone.begin(), gone.end());
  std::erase_if(fans, is_begun);
  for (OpenFan& fan : fans) {
    while (const Triangle64* corner = filled_after(fan.previous, fan.vertex)) {
      const Triangle64 wanted{fan.vertex, (*corner)[2], 0};
      const auto at = std::lower_bound(gone.begin(), gone.end(), wanted);
      fan.previous = gone.at(static_cast<std::size_t>(at - gone.begin()))[2];
    }
  }
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
  for (OpenFan& fan : fans) {
    fan = {renamed(fan.previous, fan.vertex, fan.previous),
           renamed(fan.vertex, fan.next, fan.vertex), renamed(fan.vertex, fan.next, fan.next),
           fan.component};
  }
  return fans;
}

/// The corners of filled loops, (arriving from, vertex, leaving to), sorted. Against the loops: the
/// direction of the fans.
std::vector<Triangle64> filled_corners(std::span<const BoundaryLoop> loops,
                                       std::span<const HoleFacts> holes) {
  std::vector<Triangle64> corners;
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (!holes[l].filled) continue;
    const std::vector<std::uint64_t>& loop = loops[l].vertices;
    const std::size_t n = loop.size();
    for (std::size_t i = 0; i < n; ++i)
      corners.push_back({loop[(i + 2) % n], loop[(i + 1) % n], loop[i]});
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

/// Connected pieces once patches join them, without those that are removed.
std::uint64_t count_components(const UnfilledMesh& mesh, std::span<const BoundaryLoop> loops,
                               std::span<const HoleFacts> holes) {
  DisjointSets pieces(mesh.pieces.size());
  const auto piece_of = [&](std::size_t loop) {
    return static_cast<std::uint32_t>(loops[loop].components.front());
  };
  for (std::size_t l = 0; l < loops.size(); ++l) {
    if (!holes[l].filled) continue;
    for (const std::uint64_t piece : loops[l].components)
      pieces.unite(piece_of(l), static_cast<std::uint32_t>(piece));
    if (holes[l].joined_to > 0)
      pieces.unite(piece_of(l), piece_of(static_cast<std::size_t>(holes[l].joined_to - 1)));
  }
  std::uint64_t components = 0;
  for (std::uint32_t p = 0; p < mesh.pieces.size(); ++p) {
    components += pieces.find(p) == p ? 1 : 0;
    components -= is_removed(mesh.pieces[p], mesh.min_triangles) ? 1 : 0;
  }
  return components;
}

}  // namespace

MeshFacts facts_after_fill(MeshFacts facts, UnfilledMesh mesh, std::vector<BoundaryLoop> loops,
                           const FilledHoles& filled, double patch_area) {
  for (const HoleFacts& hole : filled.holes) {
    if (!hole.filled) continue;
    facts.vertices += hole.points_added;
    facts.triangles += hole.triangles_added;
  }
  facts.components = count_components(mesh, loops, filled.holes);
  std::vector<Triangle64> corners = filled_corners(loops, filled.holes);
  loops = {};
  close_fans(corners, mesh.fans);
  corners = {};
  facts.vertices += filled.copies.size();
  facts.vertices -= filled.freed.size();
  facts.triangles -= filled.removed.size();
  facts.nonmanifold_vertices = 0;
  facts.area += patch_area;
  facts.boundary_edges = mesh.fans.size();
  facts.boundary_loops = count_loops(in_split_numbers(std::move(mesh.fans), filled.splits));
  derive_facts(facts);
  return facts;
}

}  // namespace orbweave
