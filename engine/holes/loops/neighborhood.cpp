#include "engine/holes/loops/neighborhood.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace orbweave {
namespace {

using Edge64 = std::array<std::uint64_t, 2>;

template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// Vertices reached, and the triangles at them.
struct Reached {
  std::vector<std::uint64_t> vertices;  // sorted
  std::vector<Triangle64> triangles;    // sorted
};

bool contains(std::span<const std::uint64_t> sorted, std::uint64_t vertex) {
  return std::binary_search(sorted.begin(), sorted.end(), vertex);
}

/// Rings of vertices around a loop. What lies next to a ring is of the one before, of itself or of
/// the next one, so that these three alone are searched.
class Rings {
 public:
  Rings(const Surface& surface, const BoundaryLoop& loop)
      : surface_(surface), ring_(loop.vertices) {
    sort_unique(ring_);
  }

  bool empty() const { return ring_.empty(); }

  /// Adds the ring and the triangles at it; returns the vertices beyond it, sorted.
  std::vector<std::uint64_t> take(Reached& reached) {
    std::vector<std::uint64_t> beyond;
    for (const std::uint64_t vertex : ring_) {
      at_vertex_.clear();
      surface_.triangles_at(vertex, at_vertex_);
      for (const Triangle64& t : at_vertex_) {
        if (was_seen(t, vertex)) continue;
        reached.triangles.push_back(t);
        beyond.insert(beyond.end(), t.begin(), t.end());
      }
    }
    reached.vertices.insert(reached.vertices.end(), ring_.begin(), ring_.end());
    sort_unique(beyond);
    std::erase_if(beyond, [this](std::uint64_t vertex) { return contains(ring_, vertex); });
    return beyond;
  }

  void go_on_with(std::vector<std::uint64_t> ring) {
    before_ = std::move(ring_);
    ring_ = std::move(ring);
  }

 private:
  /// At a vertex of the ring before, or at a smaller one of this ring.
  bool was_seen(const Triangle64& t, std::uint64_t vertex) const {
    return std::any_of(t.begin(), t.end(), [&](std::uint64_t other) {
      return other != vertex &&
             (contains(before_, other) || (other < vertex && contains(ring_, other)));
    });
  }

  const Surface& surface_;
  std::vector<std::uint64_t> before_, ring_;  // sorted
  std::vector<Triangle64> at_vertex_;
};

Reached walk_rings(const Surface& surface, const BoundaryLoop& loop,
                   const NeighborhoodOptions& options) {
  constexpr std::uint32_t kLeastRings = 2;
  Reached reached;
  const double limit = options.radius_factor * loop.radius;
  Rings rings(surface, loop);
  for (std::uint32_t depth = 0; !rings.empty(); ++depth) {
    std::vector<std::uint64_t> beyond = rings.take(reached);
    if (options.max_rings > 0 && depth >= options.max_rings) break;
    if (depth >= kLeastRings && reached.vertices.size() > options.max_vertices) break;
    if (depth >= kLeastRings) {
      std::erase_if(beyond, [&](std::uint64_t vertex) {
        return !(norm(surface.position(vertex) - loop.center) <= limit);
      });
    }
    rings.go_on_with(std::move(beyond));
  }
  sort_unique(reached.vertices);
  sort_unique(reached.triangles);
  return reached;
}

/// Numbers of the gathered vertices.
class Numbers {
 public:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  explicit Numbers(std::span<const std::uint64_t> vertices) : vertices_(vertices) {
    while (places_.size() < 2 * vertices.size()) places_.resize(2 * places_.size());
    std::fill(places_.begin(), places_.end(), kNone);
    for (std::uint32_t i = 0; i < vertices.size(); ++i) places_[place_of(vertices[i])] = i;
  }

  /// kNone where the vertex was not gathered.
  std::uint32_t of(std::uint64_t vertex) const { return places_[place_of(vertex)]; }

  Triangle of(const Triangle64& t) const { return {of(t[0]), of(t[1]), of(t[2])}; }

 private:
  /// Its own place, or the free one where it would go.
  std::size_t place_of(std::uint64_t vertex) const {
    constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15;
    const std::size_t mask = places_.size() - 1;
    std::size_t place = static_cast<std::size_t>((vertex * kGolden) >> 32) & mask;
    while (places_[place] != kNone && vertices_[places_[place]] != vertex)
      place = (place + 1) & mask;
    return place;
  }

  std::span<const std::uint64_t> vertices_;
  std::vector<std::uint32_t> places_ = std::vector<std::uint32_t>(16);
};

bool is_gathered(const Triangle& t) {
  return t[0] != Numbers::kNone && t[1] != Numbers::kNone && t[2] != Numbers::kNone;
}

/// Positions, and unit normals from all faces at each vertex, weighted by area.
void add_vertices(const Surface& surface, const Reached& reached,
                  std::span<const Triangle> triangles, HoleProblem& problem) {
  for (const std::uint64_t vertex : reached.vertices)
    problem.positions.push_back(surface.position(vertex));
  problem.normals.resize(reached.vertices.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const auto at = [&](int k) {
      return t[k] != Numbers::kNone ? problem.positions[t[k]]
                                    : surface.position(reached.triangles[i][k]);
    };
    const Vec3 a = at(0);
    const Vec3 area = cross(at(1) - a, at(2) - a);
    for (const std::uint32_t v : t)
      if (v != Numbers::kNone) problem.normals[v] = problem.normals[v] + area;
  }
  for (Vec3& normal : problem.normals) normal = normalized(normal);
}

/// Edges between rim vertices that are in use.
void add_used_edges(std::span<const Triangle> triangles, HoleProblem& problem) {
  std::vector<std::uint8_t> on_rim(problem.positions.size(), 0);
  for (const std::uint32_t v : problem.loop) on_rim[v] = 1;
  const auto is_on_rim = [&](std::uint32_t v) { return v != Numbers::kNone && on_rim[v] != 0; };
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (is_on_rim(a) && is_on_rim(b))
        problem.forbidden.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

}  // namespace

GatheredHole gather_hole(const Surface& surface, const BoundaryLoop& loop,
                         std::span<const Edge64> taken, const NeighborhoodOptions& options) {
  Reached reached = walk_rings(surface, loop, options);
  GatheredHole gathered;
  HoleProblem& problem = gathered.problem;
  const Numbers numbers(reached.vertices);
  std::vector<Triangle> triangles;
  triangles.reserve(reached.triangles.size());
  for (const Triangle64& t : reached.triangles) triangles.push_back(numbers.of(t));
  add_vertices(surface, reached, triangles, problem);
  for (const std::uint64_t vertex : loop.vertices) problem.loop.push_back(numbers.of(vertex));
  for (const Edge64& edge : taken)
    problem.forbidden.push_back({numbers.of(edge[0]), numbers.of(edge[1])});
  add_used_edges(triangles, problem);
  sort_unique(problem.forbidden);
  std::copy_if(triangles.begin(), triangles.end(), std::back_inserter(problem.sheet), is_gathered);
  problem.channels = surface.channels();
  if (problem.channels > 0) problem.values = surface.values(reached.vertices);
  gathered.vertices = std::move(reached.vertices);
  return gathered;
}

}  // namespace orbweave
