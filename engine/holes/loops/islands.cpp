#include "engine/holes/loops/islands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "engine/geometry/plane_axes.h"

namespace orbweave {
namespace {

/// How far from the hole's plane an island's centre may be, in radii of the hole.
constexpr double kMostHeight = 0.5;
constexpr double kLeastAgreement = 0.5;

class Positions {
 public:
  explicit Positions(std::span<const BoundaryVertex> vertices) : vertices_(vertices) {}
  Vec3 of(std::uint64_t vertex) const {
    return std::lower_bound(vertices_.begin(), vertices_.end(), vertex,
                            [](const BoundaryVertex& known, std::uint64_t number) {
                              return known.vertex < number;
                            })
        ->position;
  }

 private:
  std::span<const BoundaryVertex> vertices_;
};

/// Holes by where they are, a grid for each power of two of their radii.
class HoleGrid {
 public:
  HoleGrid(std::span<const BoundaryLoop> loops, std::span<const std::uint8_t> is_hole)
      : loops_(loops) {
    for (std::uint32_t l = 0; l < loops.size(); ++l) {
      if (is_hole[l] == 0 || !(loops[l].radius > 0.0)) continue;
      const int size = std::ilogb(loops[l].radius) + 1;  // cells are larger than the radius
      cells_[size][cell_of(loops[l].center, size)].push_back(l);
    }
  }

  /// Holes whose ball holds the point, by number.
  std::vector<std::uint32_t> around(Vec3 p) const {
    std::vector<std::uint32_t> found;
    for (const auto& [size, grid] : cells_) {
      const Cell middle = cell_of(p, size);
      for (int k = 0; k < 27; ++k) {
        const Cell cell = {middle[0] + k % 3 - 1, middle[1] + k / 3 % 3 - 1, middle[2] + k / 9 - 1};
        const auto at = grid.find(cell);
        if (at == grid.end()) continue;
        for (const std::uint32_t l : at->second) {
          if (norm(p - loops_[l].center) < loops_[l].radius) found.push_back(l);
        }
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  static Cell cell_of(Vec3 p, int size) {
    const auto index = [&](double x) {
      return static_cast<std::int64_t>(std::floor(std::ldexp(x, -size)));
    };
    return {index(p.x), index(p.y), index(p.z)};
  }

  std::span<const BoundaryLoop> loops_;
  std::map<int, std::map<Cell, std::vector<std::uint32_t>>> cells_;
};

/// The loop as a polygon in its plane.
class PlaneLoop {
 public:
  PlaneLoop(const BoundaryLoop& loop, const Positions& positions)
      : center_(loop.center), normal_(normalized(loop.area_vector)), axes_(plane_axes(normal_)) {
    for (const std::uint64_t vertex : loop.vertices) corners_.push_back(seen(positions.of(vertex)));
  }

  Vec3 normal() const { return normal_; }
  double height(Vec3 p) const { return dot(p - center_, normal_); }
  bool contains(Vec3 point) const {
    const auto [x, y] = seen(point);
    bool inside = false;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const auto& a = corners_[i];
      const auto& b = corners_[(i + 1) % corners_.size()];
      if ((a[1] > y) == (b[1] > y)) continue;
      if (x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])) inside = !inside;
    }
    return inside;
  }

 private:
  std::array<double, 2> seen(Vec3 p) const {
    return {dot(p - center_, axes_.u), dot(p - center_, axes_.v)};
  }

  Vec3 center_, normal_;
  PlaneAxes axes_;
  std::vector<std::array<double, 2>> corners_;
};

bool lies_in(const BoundaryLoop& island, const BoundaryLoop& hole, const Positions& positions) {
  if (island.radius >= hole.radius) return false;
  // A piece of its own, nowhere joined to the hole's.
  std::vector<std::uint64_t> common;
  std::set_intersection(island.components.begin(), island.components.end(), hole.components.begin(),
                        hole.components.end(), std::back_inserter(common));
  if (!common.empty()) return false;
  const PlaneLoop plane(hole, positions);
  if (std::abs(plane.height(island.center)) > kMostHeight * hole.radius) return false;
  if (dot(plane.normal(), normalized(island.mean_normal)) < kLeastAgreement) return false;
  std::vector<std::uint64_t> rim = hole.vertices;
  std::sort(rim.begin(), rim.end());
  return std::all_of(island.vertices.begin(), island.vertices.end(), [&](std::uint64_t vertex) {
    return !std::binary_search(rim.begin(), rim.end(), vertex) &&
           plane.contains(positions.of(vertex));
  });
}

}  // namespace

std::vector<std::vector<std::uint32_t>> find_islands(std::span<const BoundaryLoop> loops,
                                                     std::span<const std::uint8_t> is_hole,
                                                     std::span<const std::uint8_t> may_be_island,
                                                     std::span<const BoundaryVertex> vertices) {
  const Positions positions(vertices);
  const HoleGrid grid(loops, is_hole);
  std::vector<std::vector<std::uint32_t>> islands(loops.size());
  for (std::uint32_t l = 0; l < loops.size(); ++l) {
    if (may_be_island[l] == 0) continue;
    std::uint32_t smallest = l;
    for (const std::uint32_t hole : grid.around(loops[l].center)) {
      const bool smaller = smallest == l || loops[hole].radius < loops[smallest].radius;
      if (smaller && hole != l && lies_in(loops[l], loops[hole], positions)) smallest = hole;
    }
    if (smallest != l) islands[smallest].push_back(l);
  }
  return islands;
}

namespace {

struct Bridge {
  double squared_length = std::numeric_limits<double>::infinity();
  std::size_t from = 0;    // corner of the joined loop
  std::size_t island = 0;  // of those left
  std::size_t to = 0;      // corner of the island
};

Bridge shortest_bridge(std::span<const Vec3> joined, std::span<const std::vector<Vec3>> left) {
  Bridge best;
  for (std::size_t i = 0; i < left.size(); ++i) {
    for (std::size_t to = 0; to < left[i].size(); ++to) {
      for (std::size_t from = 0; from < joined.size(); ++from) {
        const double length = squared_norm(left[i][to] - joined[from]);
        if (length < best.squared_length) best = {length, from, i, to};
      }
    }
  }
  return best;
}

/// Goes round the loop up to corner `from`, over to the island, round it and back.
template <class T>
std::vector<T> spliced(std::vector<T> loop, std::size_t from, const std::vector<T>& island,
                       std::size_t to) {
  std::vector<T> part(island.begin() + static_cast<std::ptrdiff_t>(to), island.end());
  part.insert(part.end(), island.begin(), island.begin() + static_cast<std::ptrdiff_t>(to) + 1);
  part.push_back(loop[from]);
  loop.insert(loop.begin() + static_cast<std::ptrdiff_t>(from) + 1, part.begin(), part.end());
  return loop;
}

}  // namespace

BoundaryLoop join_islands(const BoundaryLoop& hole, std::span<const BoundaryLoop> loops,
                          std::span<const std::uint32_t> islands,
                          std::span<const BoundaryVertex> vertices) {
  const Positions positions(vertices);
  BoundaryLoop joined = hole;
  std::vector<Vec3> rim;
  for (const std::uint64_t vertex : hole.vertices) rim.push_back(positions.of(vertex));
  std::vector<std::vector<std::uint64_t>> left;
  std::vector<std::vector<Vec3>> left_at;
  for (const std::uint32_t l : islands) {
    left.push_back(loops[l].vertices);
    std::vector<Vec3>& at = left_at.emplace_back();
    for (const std::uint64_t vertex : loops[l].vertices) at.push_back(positions.of(vertex));
    joined.components.insert(joined.components.end(), loops[l].components.begin(),
                             loops[l].components.end());
  }
  while (!left.empty()) {
    const Bridge bridge = shortest_bridge(rim, left_at);
    const auto next = static_cast<std::ptrdiff_t>(bridge.island);
    joined.vertices = spliced(joined.vertices, bridge.from, left[bridge.island], bridge.to);
    rim = spliced(rim, bridge.from, left_at[bridge.island], bridge.to);
    left.erase(left.begin() + next);
    left_at.erase(left_at.begin() + next);
  }
  std::sort(joined.components.begin(), joined.components.end());
  joined.components.erase(std::unique(joined.components.begin(), joined.components.end()),
                          joined.components.end());
  return joined;
}

}  // namespace orbweave
