#include "engine/holes/loops/mesh_surface.h"

#include <oneapi/tbb/parallel_for.h>

#include <algorithm>

#include "engine/geometry/disjoint_sets.h"
#include "engine/holes/patch/patch_vertices.h"

namespace orbweave {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

std::uint32_t after(const Triangle& t, std::uint32_t vertex) {
  return t[0] == vertex ? t[1] : t[1] == vertex ? t[2] : t[0];
}

std::uint32_t before(const Triangle& t, std::uint32_t vertex) {
  return t[0] == vertex ? t[2] : t[1] == vertex ? t[0] : t[1];
}

/// Triangles at a vertex by the edge they have there.
class VertexEdges {
 public:
  VertexEdges(const TriangleMesh& mesh, const MeshSurface& surface, std::uint32_t vertex)
      : mesh_(mesh), at_(surface.at(vertex)), vertex_(vertex) {}

  /// The only triangle along vertex -> other; kNone where there is none.
  std::uint32_t leaving(std::uint32_t other) const { return only(other, true); }
  /// The only triangle along other -> vertex.
  std::uint32_t arriving(std::uint32_t other) const { return only(other, false); }
  /// No more than one triangle runs along the edge either way.
  bool is_sound(std::uint32_t other) const {
    return count(other, true) <= 1 && count(other, false) <= 1;
  }

 private:
  bool has(std::uint32_t triangle, std::uint32_t other, bool leaves) const {
    const Triangle& t = mesh_.triangles[triangle];
    return (leaves ? after(t, vertex_) : before(t, vertex_)) == other;
  }
  std::uint32_t only(std::uint32_t other, bool leaves) const {
    for (const std::uint32_t t : at_) {
      if (has(t, other, leaves)) return t;
    }
    return kNone;
  }
  std::size_t count(std::uint32_t other, bool leaves) const {
    std::size_t count = 0;
    for (const std::uint32_t t : at_) count += has(t, other, leaves) ? 1 : 0;
    return count;
  }

  const TriangleMesh& mesh_;
  std::span<const std::uint32_t> at_;
  std::uint32_t vertex_;
};

/// Adds the fan that begins with `first`, unless it runs into a non-manifold edge.
void follow_fan(const TriangleMesh& mesh, const VertexEdges& edges, std::uint32_t vertex,
                std::uint32_t first, std::uint64_t piece, std::vector<OpenFan>& fans) {
  const std::uint32_t next = after(mesh.triangles[first], vertex);
  if (!edges.is_sound(next)) return;
  for (std::uint32_t t = first;;) {
    const std::uint32_t previous = before(mesh.triangles[t], vertex);
    if (!edges.is_sound(previous)) return;
    t = edges.leaving(previous);
    if (t != kNone) continue;
    fans.push_back({previous, vertex, next, piece});
    return;
  }
}

/// Whether the triangles at a vertex form one closed fan in which every edge is of two triangles.
bool is_inside_sheet(const TriangleMesh& mesh, std::span<const std::uint32_t> at,
                     std::uint32_t vertex) {
  // Where the followers of the first triangle lead back to it through all others, each of them is
  // the only one along its edge.
  std::uint32_t t = at.front();
  for (std::size_t steps = 1;; ++steps) {
    const std::uint32_t previous = before(mesh.triangles[t], vertex);
    const auto follower = std::find_if(at.begin(), at.end(), [&](std::uint32_t other) {
      return after(mesh.triangles[other], vertex) == previous;
    });
    if (follower == at.end()) return false;
    t = *follower;
    if (t == at.front()) return steps == at.size();
    if (steps == at.size()) return false;
  }
}

Vec3 vertex_normal(const TriangleMesh& mesh, const MeshSurface& surface, std::uint32_t vertex) {
  Vec3 sum;
  const std::vector<Vec3>& at = mesh.vertices.positions;
  for (const std::uint32_t number : surface.at(vertex)) {
    const Triangle& t = mesh.triangles[number];
    sum = sum + cross(at[t[1]] - at[t[0]], at[t[2]] - at[t[0]]);
  }
  return sum;
}

}  // namespace

MeshSurface::MeshSurface(const TriangleMesh& mesh, std::span<const std::uint8_t> keep)
    : mesh_(&mesh), first_(mesh.vertices.size() + 1, 0) {
  const auto counts = [&](std::size_t t) { return keep.empty() || keep[t] != 0; };
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!counts(t)) continue;
    for (const std::uint32_t vertex : mesh.triangles[t]) ++first_[vertex + 1];
  }
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  triangles_.resize(first_.back());
  std::vector<std::uint64_t> place(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!counts(t)) continue;
    for (const std::uint32_t vertex : mesh.triangles[t]) triangles_[place[vertex]++] = t;
  }
}

void MeshSurface::triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const {
  const std::size_t begin = out.size();
  for (const std::uint32_t number : at(vertex)) {
    const Triangle& t = mesh_->triangles[number];
    out.push_back(smallest_first(Triangle64{t[0], t[1], t[2]}));
  }
  std::sort(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end());
}

std::uint32_t MeshSurface::channels() const {
  return static_cast<std::uint32_t>(mesh_->vertices.schema.attributes.size());
}

std::vector<double> MeshSurface::values(std::span<const std::uint64_t> vertices) const {
  return attribute_values(mesh_->vertices, vertices);
}

std::vector<std::uint32_t> unusual_vertices(const TriangleMesh& mesh, const MeshSurface& surface) {
  constexpr std::size_t kBlock = 8192;
  const std::size_t count = mesh.vertices.size();
  std::vector<std::vector<std::uint32_t>> blocks((count + kBlock - 1) / kBlock);
  tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t b) {
    const std::size_t end = std::min(count, (b + 1) * kBlock);
    for (std::size_t vertex = b * kBlock; vertex < end; ++vertex) {
      const auto number = static_cast<std::uint32_t>(vertex);
      const auto at = surface.at(vertex);
      if (!at.empty() && !is_inside_sheet(mesh, at, number)) blocks[b].push_back(number);
    }
  });
  std::vector<std::uint32_t> unusual;
  for (const std::vector<std::uint32_t>& block : blocks)
    unusual.insert(unusual.end(), block.begin(), block.end());
  return unusual;
}

MeshComponents find_components(const TriangleMesh& mesh, const MeshSurface& surface) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  DisjointSets sets(count);
  for (std::uint32_t vertex = 0; vertex < mesh.vertices.size(); ++vertex) {
    const VertexEdges edges(mesh, surface, vertex);
    for (const std::uint32_t number : surface.at(vertex)) {
      const std::uint32_t next = after(mesh.triangles[number], vertex);
      if (next < vertex) continue;  // an edge is looked at from its smaller end
      const std::uint32_t opposite = edges.arriving(next);
      if (opposite != kNone && edges.is_sound(next)) sets.unite(number, opposite);
    }
  }
  MeshComponents found;
  found.of_triangle.assign(count, 0);
  for (std::uint32_t number = 0; number < count; ++number) {
    const std::uint32_t root = sets.find(number);  // the smallest of its piece
    if (root == number) {
      found.of_triangle[number] = static_cast<std::uint32_t>(found.pieces.size());
      found.pieces.emplace_back();
    }
    const std::uint32_t piece = found.of_triangle[number] = found.of_triangle[root];
    ++found.pieces[piece].triangles;
    for (const std::uint32_t vertex : mesh.triangles[number]) {
      found.pieces[piece].box.extend(mesh.vertices.positions[vertex]);
    }
  }
  return found;
}

MeshBoundary find_boundary(const TriangleMesh& mesh, const MeshSurface& surface,
                           std::span<const std::uint32_t> vertices,
                           std::span<const std::uint32_t> piece_of_triangle) {
  MeshBoundary boundary;
  for (const std::uint32_t vertex : vertices) {
    const VertexEdges edges(mesh, surface, vertex);
    const std::size_t before_this = boundary.fans.size();
    for (const std::uint32_t t : surface.at(vertex)) {
      if (edges.arriving(after(mesh.triangles[t], vertex)) != kNone) continue;
      follow_fan(mesh, edges, vertex, t, piece_of_triangle[t], boundary.fans);
    }
    if (boundary.fans.size() == before_this) continue;
    boundary.vertices.push_back(
        {vertex, mesh.vertices.positions[vertex], vertex_normal(mesh, surface, vertex)});
  }
  return boundary;
}

MeshBoundary find_boundary(const TriangleMesh& mesh, const MeshSurface& surface,
                           std::span<const std::uint32_t> piece_of_triangle) {
  return find_boundary(mesh, surface, unusual_vertices(mesh, surface), piece_of_triangle);
}

}  // namespace orbweave
