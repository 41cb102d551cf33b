#include "engine/holes/loops/split_vertices.h"

#include <oneapi/tbb/parallel_sort.h>

#include <algorithm>
#include <array>

#include "engine/geometry/disjoint_sets.h"
#include "io/mesh_size.h"

namespace orbweave {
namespace {

/// Whether two triangles at a vertex share an edge there, one running along it each way.
bool are_linked(const Triangle64& a, const Triangle64& b, std::uint64_t vertex) {
  const auto leaving = [&](const Triangle64& t) {
    return t[0] == vertex ? t[1] : t[1] == vertex ? t[2] : t[0];
  };
  const auto arriving = [&](const Triangle64& t) {
    return t[0] == vertex ? t[2] : t[1] == vertex ? t[0] : t[1];
  };
  return leaving(a) == arriving(b) || leaving(b) == arriving(a);
}

/// No directed edge at the vertex is used twice: otherwise its fans are not told apart by edges.
bool has_sound_edges(std::span<const Triangle64> around, std::uint64_t vertex) {
  std::vector<std::array<std::uint64_t, 2>> edges;
  for (const Triangle64& t : around) {
    const int k = t[0] == vertex ? 0 : t[1] == vertex ? 1 : 2;
    edges.push_back({vertex, t[(k + 1) % 3]});
    edges.push_back({t[(k + 2) % 3], vertex});
  }
  std::sort(edges.begin(), edges.end());
  return std::adjacent_find(edges.begin(), edges.end()) == edges.end();
}

std::vector<Triangle64> triangles_around(const TriangleMesh& mesh,
                                         std::span<const std::uint32_t> at) {
  std::vector<Triangle64> around;
  for (const std::uint32_t number : at) {
    const Triangle& t = mesh.triangles[number];
    around.push_back({t[0], t[1], t[2]});
  }
  return around;
}

}  // namespace

std::vector<std::uint32_t> fan_groups(std::span<const Triangle64> triangles, std::uint64_t vertex) {
  const auto n = static_cast<std::uint32_t>(triangles.size());
  DisjointSets sets(n);
  for (std::uint32_t a = 0; a < n; ++a) {
    for (std::uint32_t b = a + 1; b < n; ++b) {
      if (are_linked(triangles[a], triangles[b], vertex)) sets.unite(a, b);
    }
  }
  std::vector<std::uint32_t> group(n);
  std::uint32_t groups = 0;
  for (std::uint32_t t = 0; t < n; ++t) {
    const std::uint32_t root = sets.find(t);  // the first of its set
    group[t] = root == t ? groups++ : group[root];
  }
  return group;
}

VertexStars::VertexStars(const TriangleMesh& mesh, std::span<const std::uint32_t> vertices)
    : vertices_(vertices.begin(), vertices.end()) {
  std::sort(vertices_.begin(), vertices_.end());
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  std::vector<std::uint8_t> is_known(mesh.vertices.size(), 0);
  for (const std::uint32_t vertex : vertices_) is_known[vertex] = 1;
  struct Corner {
    std::uint32_t vertex = 0, triangle = 0;
    auto operator<=>(const Corner&) const = default;
  };
  std::vector<Corner> corners;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t vertex : mesh.triangles[t])
      if (is_known[vertex] != 0) corners.push_back({vertex, t});
  tbb::parallel_sort(corners.begin(), corners.end());
  first_.reserve(vertices_.size() + 1);
  std::size_t at = 0;
  for (const std::uint32_t vertex : vertices_) {
    first_.push_back(at);
    while (at < corners.size() && corners[at].vertex == vertex) ++at;
  }
  first_.push_back(at);
  triangles_.reserve(corners.size());
  for (const Corner& corner : corners) triangles_.push_back(corner.triangle);
}

std::span<const std::uint32_t> VertexStars::at(std::uint32_t vertex) const {
  const auto i = static_cast<std::size_t>(
      std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
  return std::span(triangles_).subspan(first_[i], first_[i + 1] - first_[i]);
}

bool is_pinched(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles,
                std::uint32_t vertex) {
  const std::vector<Triangle64> around = triangles_around(mesh, triangles);
  if (around.empty() || !has_sound_edges(around, vertex)) return false;
  const std::vector<std::uint32_t> group = fan_groups(around, vertex);
  return std::any_of(group.begin(), group.end(), [](std::uint32_t g) { return g > 0; });
}

std::uint64_t split_vertices(TriangleMesh& mesh, const VertexStars& stars,
                             std::span<const std::uint32_t> vertices) {
  PointCloud copies;
  copies.schema = mesh.vertices.schema;
  for (const std::uint32_t vertex : vertices) {
    const std::span<const std::uint32_t> at = stars.at(vertex);
    const std::vector<std::uint32_t> group = fan_groups(triangles_around(mesh, at), vertex);
    const auto first_copy = static_cast<std::uint32_t>(mesh.vertices.size() + copies.size());
    for (std::size_t i = 0; i < group.size(); ++i) {
      if (group[i] == 0) continue;
      // Groups are numbered in the order in which they begin.
      if (mesh.vertices.size() + copies.size() < first_copy + group[i]) {
        copies.append(mesh.vertices, vertex);
      }
      for (std::uint32_t& corner : mesh.triangles[at[i]]) {
        if (corner == vertex) corner = first_copy + group[i] - 1;
      }
    }
  }
  require_mesh_in_core({}, mesh.vertices.size() + copies.size(), mesh.triangles.size());
  mesh.vertices.append(copies);
  return copies.size();
}

}  // namespace orbweave
