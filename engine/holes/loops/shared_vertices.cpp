#include "engine/holes/loops/shared_vertices.h"

#include <algorithm>

#include "io/sort_unique.h"

namespace orbweave {

SharedVertices::SharedVertices(std::span<const BoundaryLoop> loops) {
  std::vector<Visit> visits;
  for (std::uint32_t l = 0; l < loops.size(); ++l) {
    for (const std::uint64_t vertex : loops[l].vertices) visits.push_back({vertex, l});
  }
  sort_unique(visits);
  for (std::size_t i = 0, end = 0; i < visits.size(); i = end) {
    for (end = i; end < visits.size() && visits[end].vertex == visits[i].vertex;) ++end;
    if (end - i > 1) visits_.insert(visits_.end(), visits.begin() + i, visits.begin() + end);
  }
}

std::vector<std::array<std::uint64_t, 2>> SharedVertices::groups_on(const BoundaryLoop& loop,
                                                                    std::uint32_t number) const {
  std::vector<std::uint64_t> vertices = loop.vertices;
  sort_unique(vertices);
  std::vector<Visit> of_others;
  for (const std::uint64_t vertex : vertices) {
    auto at = std::lower_bound(visits_.begin(), visits_.end(), Visit{vertex, 0});
    for (; at != visits_.end() && at->vertex == vertex; ++at)
      if (at->loop != number) of_others.push_back(*at);
  }
  std::stable_sort(of_others.begin(), of_others.end(),
                   [](const Visit& a, const Visit& b) { return a.loop < b.loop; });
  std::vector<std::array<std::uint64_t, 2>> groups;
  for (std::size_t i = 0, end = 0; i < of_others.size(); i = end) {
    for (end = i; end < of_others.size() && of_others[end].loop == of_others[i].loop;) ++end;
    if (end - i < 2) continue;
    const std::uint64_t group = std::uint64_t{number} << 32 | of_others[i].loop;
    for (std::size_t at = i; at < end; ++at) groups.push_back({of_others[at].vertex, group});
  }
  return groups;
}

}  // namespace orbweave
