#include "engine/levels/flaps.h"

#include <algorithm>
#include <cstddef>

#include "engine/levels/marks.h"

namespace orbweave {
namespace {

/// A triangle as one side of a flap.
struct Side {
  Triangle corners{};   ///< ascending
  bool is_odd = false;  ///< the triangle runs through them the other way round
  std::uint32_t triangle = 0;
  friend auto operator<=>(const Side&, const Side&) = default;
};

Side side_of(const Triangle& t, std::uint32_t number) {
  Side side{t, false, number};
  std::sort(side.corners.begin(), side.corners.end());
  const auto first = static_cast<std::size_t>(std::min_element(t.begin(), t.end()) - t.begin());
  side.is_odd = t[(first + 1) % 3] > t[(first + 2) % 3];
  return side;
}

}  // namespace

std::vector<Triangle> without_flaps(std::span<const Triangle> triangles,
                                    std::span<const std::uint32_t> unsound,
                                    std::span<const std::uint32_t> locked) {
  const Marks is_unsound(unsound);
  const Marks is_locked(locked);
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    // The edge that a flap has in common with the surface has four triangles.
    if (is_unsound.count(triangles[t]) >= 2 && is_locked.count(triangles[t]) < 2)
      sides.push_back(side_of(triangles[t], t));
  std::sort(sides.begin(), sides.end());
  std::vector<bool> goes(triangles.size());
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].corners == sides[begin].corners) ++end;
    std::size_t even = begin;
    for (std::size_t odd = begin; odd < end; ++odd)
      if (sides[odd].is_odd && !sides[even].is_odd) {
        goes[sides[even++].triangle] = true;
        goes[sides[odd].triangle] = true;
      }
  }
  std::vector<Triangle> kept;
  kept.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (!goes[t]) kept.push_back(triangles[t]);
  return kept;
}

}  // namespace orbweave
