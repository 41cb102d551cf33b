#include "engine/voronoi/tetrahedra.h"

#include <numeric>

namespace orbweave::voronoi {

void number_by(std::vector<std::uint32_t>& smallest, std::size_t points) {
  std::vector<std::uint32_t> next(points + 1, 0);
  for (const std::uint32_t vertex : smallest)
    if (vertex != kInfinite) ++next[vertex + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::uint32_t& vertex : smallest)
    if (vertex != kInfinite) vertex = next[vertex]++;
}

Stars stars_of(const Tetrahedra& tetrahedra, std::size_t points) {
  Stars stars;
  stars.begin.assign(points + 2, 0);
  for (const auto& cell : tetrahedra.vertices)
    for (const std::uint32_t vertex : cell)
      if (vertex != kInfinite) ++stars.begin[vertex + 2];
  for (std::size_t i = 2; i < stars.begin.size(); ++i) stars.begin[i] += stars.begin[i - 1];
  stars.cells.resize(stars.begin.back());
  for (std::uint32_t c = 0; c < tetrahedra.size(); ++c)
    for (const std::uint32_t vertex : tetrahedra.vertices[c])
      if (vertex != kInfinite) stars.cells[stars.begin[vertex + 1]++] = c;
  stars.begin.pop_back();
  return stars;
}

}  // namespace orbweave::voronoi
