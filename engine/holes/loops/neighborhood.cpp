#include "engine/holes/loops/neighborhood.h"

#include <algorithm>

namespace orbweave {
namespace {

using Edge64 = std::array<std::uint64_t, 2>;

template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

/// Vertices reached so far, and the triangles seen at them.
struct Reached {
  std::vector<std::uint64_t> vertices;  // sorted
  std::vector<Triangle64> triangles;    // at all of `vertices`, sorted
};

Reached walk_rings(const Surface& surface, const BoundaryLoop& loop,
                   const NeighborhoodOptions& options) {
  constexpr std::uint32_t kLeastRings = 2;
  Reached reached;
  const double limit = options.radius_factor * loop.radius;
  std::vector<std::uint64_t> ring = loop.vertices;
  sort_unique(ring);
  std::vector<Triangle64> at_vertex;
  for (std::uint32_t depth = 0; !ring.empty(); ++depth) {
    std::vector<std::uint64_t> beyond;
    const std::size_t before = reached.triangles.size();
    for (const std::uint64_t vertex : ring) {
      at_vertex.clear();
      surface.triangles_at(vertex, at_vertex);
      for (const Triangle64& t : at_vertex) {
        reached.triangles.push_back(t);
        beyond.insert(beyond.end(), t.begin(), t.end());
      }
    }
    std::sort(reached.triangles.begin() + static_cast<std::ptrdiff_t>(before),
              reached.triangles.end());
    std::inplace_merge(reached.triangles.begin(),
                       reached.triangles.begin() + static_cast<std::ptrdiff_t>(before),
                       reached.triangles.end());
    reached.triangles.erase(std::unique(reached.triangles.begin(), reached.triangles.end()),
                            reached.triangles.end());
    const auto middle = static_cast<std::ptrdiff_t>(reached.vertices.size());
    reached.vertices.insert(reached.vertices.end(), ring.begin(), ring.end());
    std::inplace_merge(reached.vertices.begin(), reached.vertices.begin() + middle,
                       reached.vertices.end());
    if (options.max_rings > 0 && depth >= options.max_rings) break;
    if (depth >= kLeastRings && reached.vertices.size() > options.max_vertices) break;
    sort_unique(beyond);
    ring.clear();
    for (const std::uint64_t vertex : beyond) {
      if (std::binary_search(reached.vertices.begin(), reached.vertices.end(), vertex)) continue;
      const bool near = norm(surface.position(vertex) - loop.center) <= limit;
      if (near || depth < kLeastRings) ring.push_back(vertex);
    }
  }
  return reached;
}

std::uint32_t index_of(std::span<const std::uint64_t> vertices, std::uint64_t vertex) {
  const auto at = std::lower_bound(vertices.begin(), vertices.end(), vertex);
  return static_cast<std::uint32_t>(at - vertices.begin());
}

bool contains(std::span<const std::uint64_t> vertices, std::uint64_t vertex) {
  return std::binary_search(vertices.begin(), vertices.end(), vertex);
}

/// Unit normals from all faces at each vertex, weighted by area.
std::vector<Vec3> vertex_normals(const Surface& surface, const Reached& reached) {
  std::vector<Vec3> normals(reached.vertices.size());
  for (const Triangle64& t : reached.triangles) {
    const Vec3 a = surface.position(t[0]);
    const Vec3 area = cross(surface.position(t[1]) - a, surface.position(t[2]) - a);
    for (const std::uint64_t vertex : t) {
      if (!contains(reached.vertices, vertex)) continue;
      Vec3& normal = normals[index_of(reached.vertices, vertex)];
      normal = normal + area;
    }
  }
  for (Vec3& normal : normals) normal = normalized(normal);
  return normals;
}

/// Edges between rim vertices that are in use.
std::vector<Edge64> used_edges(const Reached& reached, std::span<const std::uint64_t> rim,
                               std::span<const Edge64> taken) {
  std::vector<Edge64> edges(taken.begin(), taken.end());
  for (const Triangle64& t : reached.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k], b = t[(k + 1) % 3];
      if (contains(rim, a) && contains(rim, b)) edges.push_back({std::min(a, b), std::max(a, b)});
    }
  }
  sort_unique(edges);
  return edges;
}

}  // namespace

GatheredHole gather_hole(const Surface& surface, const BoundaryLoop& loop,
                         std::span<const Edge64> taken, const NeighborhoodOptions& options) {
  Reached reached = walk_rings(surface, loop, options);
  GatheredHole gathered;
  HoleProblem& problem = gathered.problem;
  problem.normals = vertex_normals(surface, reached);
  std::vector<std::uint64_t> rim = loop.vertices;
  sort_unique(rim);
  const auto index = [&](std::uint64_t vertex) { return index_of(reached.vertices, vertex); };
  for (const Edge64& edge : used_edges(reached, rim, taken)) {
    problem.forbidden.push_back({index(edge[0]), index(edge[1])});
  }
  for (const std::uint64_t vertex : reached.vertices) {
    problem.positions.push_back(surface.position(vertex));
  }
  for (const Triangle64& t : reached.triangles) {
    if (!contains(reached.vertices, t[0]) || !contains(reached.vertices, t[1]) ||
        !contains(reached.vertices, t[2])) {
      continue;
    }
    problem.sheet.push_back({index(t[0]), index(t[1]), index(t[2])});
  }
  for (const std::uint64_t vertex : loop.vertices) problem.loop.push_back(index(vertex));
  problem.channels = surface.channels();
  if (problem.channels > 0) problem.values = surface.values(reached.vertices);
  gathered.vertices = std::move(reached.vertices);
  return gathered;
}

}  // namespace orbweave
