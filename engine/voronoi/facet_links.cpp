#include "engine/voronoi/facet_links.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace orbweave::voronoi {
namespace {

std::size_t at(int place) { return static_cast<std::size_t>(place); }

/// How many of four flags are set: what std::popcount asks a library for on common processors.
std::uint32_t count_flags(unsigned flags) {
  static constexpr std::array<std::uint8_t, 16> kCount = {0, 1, 1, 2, 1, 2, 2, 3,
                                                          1, 2, 2, 3, 2, 3, 3, 4};
  return kCount[flags & 15U];
}

}  // namespace

FacetLinks::FacetLinks(std::span<const Vec3> points, const Tetrahedra& tetrahedra,
                       const FacetFlags& flags, const StopToken* stop) {
  number(tetrahedra, flags);
  normals_.reserve(corners_.size() / 2);
  for (FacetHalf half = 0; half < halves(); half += 2) {
    const Triangle& t = corners_[half];
    normals_.push_back(normalized(cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]])));
  }
  across_.assign(3 * corners_.size(), kGone);
  link_by_corners();
  for (HalfEdge edge = 0; edge < across_.size(); ++edge) {
    if (edge % kStopBlock == 0) check_stop(stop);
    if (across_[edge] == kGone) link(tetrahedra, edge);
  }
}

void FacetLinks::number(const Tetrahedra& tetrahedra, const FacetFlags& flags) {
  flags_ = flags.bits();
  first_.resize(tetrahedra.size());
  std::uint32_t count = 0;
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    first_[c] = count;
    count += count_flags(flags_[c]);
  }
  sides_.reserve(count);
  corners_.reserve(count);
  half_at_.resize(count);
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c) {
    if (flags_[c] == 0) continue;
    for (int place = 0; place < 4; ++place) {
      if (!has(c, place) || tetrahedra.neighbors[c][at(place)] < c) continue;
      const Triangle corners = smallest_first(corners_of(tetrahedra, {c, place}));
      add({c, place}, corners);
      // From behind, the edges follow each other the other way.
      add(flags.opposite({c, place}), {corners[0], corners[2], corners[1]});
    }
  }
}

void FacetLinks::add(FacetSide side, const Triangle& corners) {
  half_at_[slot(side)] = halves();
  sides_.push_back(side);
  corners_.push_back(corners);
}

std::size_t FacetLinks::slot(FacetSide side) const {
  const unsigned before = flags_[side.cell] & ((1U << side.place) - 1U);
  return first_[side.cell] + count_flags(before);
}

/// Links the edges of one or two facets: the sides that follow each other there run along the edge
/// in opposite directions, whatever lies between.
void FacetLinks::link_by_corners() {
  struct Use {
    std::uint32_t larger = 0;  ///< of the edge's ends
    HalfEdge edge = 0;
  };
  std::uint32_t points = 0;
  for (const Triangle& corners : corners_)
    points = std::max({points, corners[0] + 1, corners[1] + 1, corners[2] + 1});
  std::vector<std::uint32_t> begin(points + 2, 0);  // of the uses at each edge's smaller end
  const auto visit = [&](const auto& use) {
    for (FacetHalf half = 0; half < halves(); half += 2)
      for (HalfEdge edge = 3 * half; edge < 3 * half + 3; ++edge)
        use(std::min(start(edge), end(edge)), std::max(start(edge), end(edge)), edge);
  };
  visit([&](std::uint32_t smaller, std::uint32_t, HalfEdge) { ++begin[smaller + 2]; });
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<Use> uses(begin.back());
  visit([&](std::uint32_t smaller, std::uint32_t larger, HalfEdge edge) {
    uses[begin[smaller + 1]++] = {larger, edge};
  });
  for (std::uint32_t v = 0; v < points; ++v) {
    const std::span<Use> here(uses.data() + begin[v], begin[v + 1] - begin[v]);
    std::sort(here.begin(), here.end(),
              [](const Use& a, const Use& b) { return a.larger < b.larger; });
    for (std::size_t i = 0, next = 0; i < here.size(); i = next) {
      while (next < here.size() && here[next].larger == here[i].larger) ++next;
      const HalfEdge first = here[i].edge;
      if (next - i == 1) join(first, behind(first));
      if (next - i != 2) continue;
      const HalfEdge other = here[i + 1].edge;
      const bool is_reversed = start(other) == end(first);
      join(first, is_reversed ? other : behind(other));
      join(behind(first), is_reversed ? behind(other) : other);
    }
  }
}

/// Goes around an edge from tetrahedron to tetrahedron until a flagged facet ends the way.
void FacetLinks::link(const Tetrahedra& tetrahedra, HalfEdge edge) {
  const std::uint32_t a = start(edge), b = end(edge);
  std::uint32_t behind = apex(edge), cell = sides_[half_of(edge)].cell;
  while (true) {
    const int place = tetrahedra.place_of_vertex(cell, behind);
    if (has(cell, place)) {
      across_[edge] = edge_of(half_of(FacetSide{cell, place}), b);
      across_[across_[edge]] = edge;
      return;
    }
    const auto& vertices = tetrahedra.vertices[cell];
    std::uint32_t ahead = behind;
    for (const std::uint32_t v : vertices)
      if (v != a && v != b && v != behind) ahead = v;
    behind = ahead;
    cell = tetrahedra.neighbors[cell][at(place)];
  }
}

void FacetLinks::remove(FacetHalf half) {
  for (std::uint32_t k = 0; k < 3; ++k) {
    const HalfEdge here = 3 * half + k;
    const HalfEdge there = behind(here);
    const HalfEdge before = across_[here], after = across_[there];
    if (before != there) {
      across_[before] = after;
      across_[after] = before;
    }
  }
  for (std::uint32_t k = 0; k < 3; ++k)
    across_[3 * half + k] = across_[3 * opposite(half) + k] = kGone;
}

bool folds_back(std::span<const Vec3> points, const FacetLinks& links, HalfEdge edge) {
  const std::uint32_t a = links.start(edge), x = links.apex(edge);
  const std::uint32_t y = links.apex(links.across(edge));
  if (x == y) return true;
  if (is_certainly_open(links, edge)) return false;
  const Vec3 along = points[links.end(edge)] - points[a];
  const Vec3 u = cross(along, points[x] - points[a]);
  const Vec3 v = cross(along, points[y] - points[a]);
  return dot(u, v) > 0.0 && dot(along, cross(u, v)) < 0.0;
}

}  // namespace orbweave::voronoi
