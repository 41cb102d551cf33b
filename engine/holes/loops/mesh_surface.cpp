#include "engine/holes/loops/mesh_surface.h"

#include <algorithm>

#include "engine/geometry/concurrent_sets.h"
#include "engine/holes/patch/patch_vertices.h"
#include "io/whole_loop.h"

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

constexpr std::size_t kBlock = 8192;

std::size_t blocks_of(std::size_t count) { return (count + kBlock - 1) / kBlock; }

/// Calls work(block, begin, end) for each block of numbers below `count`, in parallel.
template <class Work>
void for_each_block(std::size_t count, const Work& work) {
  for_each_whole(blocks_of(count),
                 [&](std::size_t b) { work(b, b * kBlock, std::min(count, (b + 1) * kBlock)); });
}

/// Joins the triangles at each vertex that is simply inside a sheet: each has an edge of two
/// triangles in common with the next.
void join_closed_fans(const TriangleMesh& mesh, const MeshSurface& surface,
                      std::span<const std::uint32_t> unusual, ConcurrentSets& sets) {
  for_each_block(mesh.vertices.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    auto skipped = std::lower_bound(unusual.begin(), unusual.end(), begin);
    for (std::size_t vertex = begin; vertex < end; ++vertex) {
      if (skipped != unusual.end() && *skipped == vertex) {
        ++skipped;
        continue;
      }
      const auto at = surface.at(vertex);
      for (std::size_t i = 1; i < at.size(); ++i) sets.unite(at[i], at.front());
    }
  });
}

/// Joins the triangles along each edge at a vertex that has just one of them either way.
void join_over_edges(const TriangleMesh& mesh, const MeshSurface& surface, std::uint32_t vertex,
                     ConcurrentSets& sets) {
  const VertexEdges edges(mesh, surface, vertex);
  for (const std::uint32_t number : surface.at(vertex)) {
    const std::uint32_t next = after(mesh.triangles[number], vertex);
    const std::uint32_t opposite = edges.arriving(next);
    if (opposite != kNone && edges.is_sound(next)) sets.unite(number, opposite);
  }
}

/// Triangles of one piece, one after another.
struct PieceRun {
  std::uint32_t piece = 0;
  Piece part;
};

/// From the first triangle of each triangle's piece to the pieces, in the order of these.
void number_pieces(const TriangleMesh& mesh, MeshComponents& found) {
  std::vector<std::uint32_t>& piece_of = found.of_triangle;
  const std::size_t count = piece_of.size();
  std::vector<std::uint32_t> roots;  // ascending, so that a piece's number is its place
  for (std::uint32_t t = 0; t < count; ++t)
    if (piece_of[t] == t) roots.push_back(t);
  found.pieces.resize(roots.size());
  std::vector<std::vector<PieceRun>> runs(blocks_of(count));
  for_each_block(count, [&](std::size_t b, std::size_t begin, std::size_t end) {
    std::uint32_t root = kNone;
    for (std::size_t t = begin; t < end; ++t) {
      if (piece_of[t] != root) {
        root = piece_of[t];
        const auto place = std::lower_bound(roots.begin(), roots.end(), root) - roots.begin();
        runs[b].push_back({static_cast<std::uint32_t>(place), {}});
      }
      PieceRun& run = runs[b].back();
      piece_of[t] = run.piece;
      ++run.part.triangles;
      for (const std::uint32_t vertex : mesh.triangles[t])
        run.part.box.extend(mesh.vertices.positions[vertex]);
    }
  });
  for (const std::vector<PieceRun>& block : runs)
    for (const PieceRun& run : block) {
      Piece& piece = found.pieces[run.piece];
      piece.triangles += run.part.triangles;
      piece.box.extend(run.part.box);
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

void MeshSurface::new_triangles_at(std::span<const std::uint64_t> vertices, TriangleMarks& met,
                                   std::vector<Triangle64>& out) const {
  for (const std::uint64_t vertex : vertices)
    for (const std::uint32_t number : at(vertex)) {
      if (!met.mark(std::uint64_t{number})) continue;
      const Triangle& t = mesh_->triangles[number];
      out.push_back(smallest_first(Triangle64{t[0], t[1], t[2]}));
    }
}

std::uint32_t MeshSurface::channels() const {
  return static_cast<std::uint32_t>(mesh_->vertices.schema.attributes.size());
}

std::vector<double> MeshSurface::values(std::span<const std::uint64_t> vertices) const {
  return attribute_values(mesh_->vertices, vertices);
}

std::vector<std::uint32_t> unusual_vertices(const TriangleMesh& mesh, const MeshSurface& surface) {
  const std::size_t count = mesh.vertices.size();
  std::vector<std::vector<std::uint32_t>> blocks(blocks_of(count));
  for_each_block(count, [&](std::size_t b, std::size_t begin, std::size_t end) {
    for (std::size_t vertex = begin; vertex < end; ++vertex) {
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

MeshComponents find_components(const TriangleMesh& mesh, const MeshSurface& surface,
                               std::span<const std::uint32_t> unusual) {
  ConcurrentSets sets(mesh.triangles.size());
  join_closed_fans(mesh, surface, unusual, sets);
  for_each_block(unusual.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) join_over_edges(mesh, surface, unusual[i], sets);
  });
  MeshComponents found;
  found.of_triangle = sets.take_roots();
  number_pieces(mesh, found);
  return found;
}

MeshComponents find_components(const TriangleMesh& mesh, const MeshSurface& surface) {
  return find_components(mesh, surface, unusual_vertices(mesh, surface));
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
