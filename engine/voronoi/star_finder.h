// The tetrahedra at single vertices, for algorithms that ask about few of them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/tetrahedra.h"

namespace orbweave::voronoi {

class StarFinder {
 public:
  /// `tetrahedra` have to outlive the object; their vertices are below `points`.
  StarFinder(const Tetrahedra& tetrahedra, std::size_t points);

  /// The tetrahedra at a vertex, ascending, as Stars has them; until the next call.
  std::span<const std::uint32_t> find(std::uint32_t vertex);

  /// The place of a tetrahedron in the star that was found last.
  std::uint32_t place(std::uint32_t cell) const { return places_[cell]; }

 private:
  bool is_found(std::uint32_t cell) const {
    return places_[cell] < star_.size() && star_[places_[cell]] == cell;
  }
  void add(std::uint32_t cell);

  const Tetrahedra& tetrahedra_;
  std::vector<std::uint32_t> any_;  // a tetrahedron of each vertex
  std::vector<std::uint32_t> star_;
  std::vector<std::uint32_t> places_;  // in the star; anything where a tetrahedron is in none
};

}  // namespace orbweave::voronoi
