#include "engine/voronoi/star_finder.h"

#include <algorithm>
#include <cstddef>

namespace orbweave::voronoi {

StarFinder::StarFinder(const Tetrahedra& tetrahedra, std::size_t points)
    : tetrahedra_(tetrahedra), any_(points, kNone), places_(tetrahedra.size(), 0) {
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c)
    for (const std::uint32_t vertex : tetrahedra.vertices[c])
      if (vertex != kInfinite) any_[vertex] = c;
}

std::span<const std::uint32_t> StarFinder::find(std::uint32_t vertex) {
  star_.clear();
  if (any_[vertex] == kNone) return star_;
  add(any_[vertex]);
  for (std::size_t i = 0; i < star_.size(); ++i) {
    const std::uint32_t cell = star_[i];
    for (std::size_t place = 0; place < 4; ++place) {
      const std::uint32_t next = tetrahedra_.neighbors[cell][place];
      if (tetrahedra_.vertices[cell][place] != vertex && !is_found(next)) add(next);
    }
  }
  std::sort(star_.begin(), star_.end());
  for (std::uint32_t i = 0; i < star_.size(); ++i) places_[star_[i]] = i;
  return star_;
}

void StarFinder::add(std::uint32_t cell) {
  places_[cell] = static_cast<std::uint32_t>(star_.size());
  star_.push_back(cell);
}

}  // namespace orbweave::voronoi
