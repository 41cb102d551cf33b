#include "engine/holes/loops/islands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>

#include "engine/geometry/plane_axes.h"

namespace orbweave {
namespace {

/// How far from the hole's plane an island's centre may be, in radii of the hole.
constexpr double kMostHeight = 0.5;
constexpr double kLeastAgreement = 0.5;

/// Comparisons of some nanoseconds between two looks at the request to stop.
constexpr std::uint64_t kLookEvery = 256 * kStopBlock;

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
    vertices_ = loop.vertices;
    std::sort(vertices_.begin(), vertices_.end());
  }

  Vec3 normal() const { return normal_; }
  double height(Vec3 p) const { return dot(p - center_, normal_); }
  std::size_t size() const { return corners_.size(); }
  bool visits(std::uint64_t vertex) const {
    return std::binary_search(vertices_.begin(), vertices_.end(), vertex);
  }
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
  std::vector<std::uint64_t> vertices_;  // sorted
};

/// Whether an island is small enough and a piece of its own, nowhere joined to the hole's.
bool may_lie_in(const BoundaryLoop& island, const BoundaryLoop& hole) {
  if (island.radius >= hole.radius) return false;
  std::vector<std::uint64_t> common;
  std::set_intersection(island.components.begin(), island.components.end(), hole.components.begin(),
                        hole.components.end(), std::back_inserter(common));
  return common.empty();
}

/// The holes' polygons, each made when it is first asked for.
class PlaneLoops {
 public:
  PlaneLoops(std::span<const BoundaryLoop> loops, const Positions& positions, const StopToken* stop)
      : loops_(loops), positions_(positions), made_(loops.size()), looks_(stop, kLookEvery) {}

  bool lies_in(const BoundaryLoop& island, std::uint32_t hole) {
    if (!may_lie_in(island, loops_[hole])) return false;
    if (!made_[hole]) made_[hole] = std::make_unique<PlaneLoop>(loops_[hole], positions_);
    const PlaneLoop& plane = *made_[hole];
    if (std::abs(plane.height(island.center)) > kMostHeight * loops_[hole].radius) return false;
    if (dot(plane.normal(), normalized(island.mean_normal)) < kLeastAgreement) return false;
    return std::all_of(island.vertices.begin(), island.vertices.end(), [&](std::uint64_t vertex) {
      looks_.after(plane.size());
      return !plane.visits(vertex) && plane.contains(positions_.of(vertex));
    });
  }

 private:
  std::span<const BoundaryLoop> loops_;
  const Positions& positions_;
  std::vector<std::unique_ptr<PlaneLoop>> made_;
  StopLooks looks_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> find_islands(std::span<const BoundaryLoop> loops,
                                                     std::span<const std::uint8_t> is_hole,
                                                     std::span<const std::uint8_t> may_be_island,
                                                     std::span<const BoundaryVertex> vertices,
                                                     const StopToken* stop) {
  const Positions positions(vertices);
  const HoleGrid grid(loops, is_hole);
  PlaneLoops planes(loops, positions, stop);
  std::vector<std::vector<std::uint32_t>> islands(loops.size());
  for (std::uint32_t l = 0; l < loops.size(); ++l) {
    if (may_be_island[l] == 0) continue;
    std::uint32_t smallest = l;
    for (const std::uint32_t hole : grid.around(loops[l].center)) {
      const bool smaller = smallest == l || loops[hole].radius < loops[smallest].radius;
      if (smaller && hole != l && planes.lies_in(loops[l], hole)) smallest = hole;
    }
    if (smallest != l) islands[smallest].push_back(l);
  }
  return islands;
}

namespace {

/// The shortest way from what is joined to an island. Of equally short ones the one whose corner of
/// the island comes first, then the one whose corner of the joined loop does.
struct Bridge {
  double squared_length = std::numeric_limits<double>::infinity();
  std::size_t to = 0;    // corner of the island
  std::size_t from = 0;  // corner of the joined loop
  friend auto operator<=>(const Bridge&, const Bridge&) = default;
};

/// An island that is not joined yet.
struct Island {
  std::vector<std::uint64_t> vertices;
  std::vector<Vec3> corners;
  Bridge bridge;
};

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

/// Joins islands one by one, always the one that is nearest to what is joined (Prim, Shortest
/// connection networks, 1957). Each island knows its bridge, so that only the corners joined last
/// are compared with its own: the time grows with the square of the number of corners.
class IslandJoiner {
 public:
  IslandJoiner(const BoundaryLoop& hole, const Positions& positions, const StopToken* stop)
      : positions_(positions), joined_(hole.vertices), looks_(stop, kLookEvery) {
    rim_ = corners_of(hole);
  }

  void add(const BoundaryLoop& island) {
    Island& added = left_.emplace_back(Island{island.vertices, corners_of(island), {}});
    shorten(added, 0, rim_.size());
  }

  std::vector<std::uint64_t> joined() && {
    while (!left_.empty()) join_nearest();
    return std::move(joined_);
  }

 private:
  std::vector<Vec3> corners_of(const BoundaryLoop& loop) const {
    std::vector<Vec3> corners;
    for (const std::uint64_t vertex : loop.vertices) corners.push_back(positions_.of(vertex));
    return corners;
  }

  /// Compares corners [begin, end) of the joined loop with the island's.
  void shorten(Island& island, std::size_t begin, std::size_t end) {
    Bridge& best = island.bridge;
    for (std::size_t to = 0; to < island.corners.size(); ++to) {
      for (std::size_t from = begin; from < end; ++from) {
        const double length = squared_norm(island.corners[to] - rim_[from]);
        if (length > best.squared_length) continue;
        best = std::min(best, Bridge{length, to, from});
      }
      looks_.after(end - begin);
    }
  }

  void join_nearest() {
    // Islands that are equally near are joined in their order.
    const auto nearest = std::ranges::min_element(
        left_, {}, [](const Island& island) { return island.bridge.squared_length; });
    const Bridge bridge = nearest->bridge;
    const std::size_t corners = nearest->corners.size();
    joined_ = spliced(std::move(joined_), bridge.from, nearest->vertices, bridge.to);
    rim_ = spliced(std::move(rim_), bridge.from, nearest->corners, bridge.to);
    left_.erase(nearest);
    // Behind the island come the two ends of the bridge once more, which are never nearer than
    // where the loop visits them first.
    const std::size_t first = bridge.from + 1, added = corners + 2;
    for (Island& island : left_) {
      if (island.bridge.from > bridge.from) island.bridge.from += added;
      shorten(island, first, first + corners);
    }
  }

  const Positions& positions_;
  std::vector<std::uint64_t> joined_;
  std::vector<Vec3> rim_;  // positions of `joined_`
  std::vector<Island> left_;
  StopLooks looks_;
};

}  // namespace

BoundaryLoop join_islands(const BoundaryLoop& hole, std::span<const BoundaryLoop> loops,
                          std::span<const std::uint32_t> islands,
                          std::span<const BoundaryVertex> vertices, const StopToken* stop) {
  const Positions positions(vertices);
  BoundaryLoop joined = hole;
  IslandJoiner joiner(hole, positions, stop);
  for (const std::uint32_t l : islands) {
    joiner.add(loops[l]);
    joined.components.insert(joined.components.end(), loops[l].components.begin(),
                             loops[l].components.end());
  }
  joined.vertices = std::move(joiner).joined();
  std::sort(joined.components.begin(), joined.components.end());
  joined.components.erase(std::unique(joined.components.begin(), joined.components.end()),
                          joined.components.end());
  return joined;
}

}  // namespace orbweave
