#include "engine/ball_pivoting/site_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <tuple>

namespace orbweave {

bool PointSelection::takes(Vec3 p) const {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto bits = std::bit_cast<std::uint64_t>(p[axis] == 0.0 ? 0.0 : p[axis]);
    hash = (hash ^ (bits & 0x800FFFFFFFFFFFFFu)) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 32;
  }
  return hash * 0xBF58476D1CE4E5B9u <= last;
}

PointSelection select_points(std::span<const SpacingSite> sites, std::uint64_t wanted) {
  std::uint64_t points = 0;
  for (const SpacingSite& site : sites) points += site.points.size();
  if (points <= wanted) return {};
  return {~std::uint64_t{0} / points * wanted};
}

std::vector<SpacingSite> distinct_sites(std::span<const SpacingSite> sites) {
  std::vector<SpacingSite> distinct(sites.begin(), sites.end());
  tbb::parallel_for(std::size_t{0}, distinct.size(), [&](std::size_t i) {
    std::vector<Vec3>& points = distinct[i].points;
    std::sort(points.begin(), points.end(),
              [](Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
  });
  return distinct;
}

double distance_to_border(Vec3 p, const Box& box) {
  double distance = p.x - box.min.x;
  for (int axis = 0; axis < 3; ++axis)
    distance = std::min({distance, p[axis] - box.min[axis], box.max[axis] - p[axis]});
  return distance;
}

std::string short_text(double value) {
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 4);
  return std::string(text.data(), end.ptr);
}

}  // namespace orbweave
