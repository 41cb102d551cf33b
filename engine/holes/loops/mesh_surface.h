// A mesh in core as the hole pass sees it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/loops/hole_choice.h"
#include "engine/holes/problem/boundary_loop.h"
#include "engine/holes/problem/surface.h"
#include "io/triangle_mesh.h"

namespace orbweave {

class MeshSurface : public Surface {
 public:
  /// The mesh has to outlive the surface. `keep` is empty or says per triangle whether it counts.
  explicit MeshSurface(const TriangleMesh& mesh, std::span<const std::uint8_t> keep = {});

  Vec3 position(std::uint64_t vertex) const override { return mesh_->vertices.positions[vertex]; }
  bool is_at_hand() const override { return true; }
  using Surface::triangles_at;
  void triangles_at(std::uint64_t vertex, std::vector<Triangle64>& out) const override;
  void new_triangles_at(std::span<const std::uint64_t> vertices, TriangleMarks& met,
                        std::vector<Triangle64>& out) const override;
  std::uint32_t channels() const override;
  std::vector<double> values(std::span<const std::uint64_t> vertices) const override;

  /// Numbers of the triangles at a vertex.
  std::span<const std::uint32_t> at(std::uint64_t vertex) const {
    return {triangles_.data() + first_[vertex], triangles_.data() + first_[vertex + 1]};
  }

 private:
  const TriangleMesh* mesh_;
  std::vector<std::uint64_t> first_;  // per vertex, and one past the last
  std::vector<std::uint32_t> triangles_;
};

/// Vertices that are not simply inside a sheet, ascending: their triangles do not form one closed
/// fan in which every edge is of two triangles. Unused vertices are left out. Parallel.
std::vector<std::uint32_t> unusual_vertices(const TriangleMesh& mesh, const MeshSurface& surface);

/// Connected pieces (over edges of two triangles), in the order of their first triangles. Parallel.
struct MeshComponents {
  std::vector<Piece> pieces;
  std::vector<std::uint32_t> of_triangle;
};
MeshComponents find_components(const TriangleMesh& mesh, const MeshSurface& surface,
                               std::span<const std::uint32_t> unusual);
MeshComponents find_components(const TriangleMesh& mesh, const MeshSurface& surface);

/// The open fans, and the vertices they lie at. Fans that end at an edge of more than two
/// triangles, or of two that run along it in the same direction, are left out.
struct MeshBoundary {
  std::vector<OpenFan> fans;
  std::vector<BoundaryVertex> vertices;
};
/// `vertices`: where to look, ascending; unusual_vertices() holds all that count.
MeshBoundary find_boundary(const TriangleMesh& mesh, const MeshSurface& surface,
                           std::span<const std::uint32_t> vertices,
                           std::span<const std::uint32_t> piece_of_triangle);
MeshBoundary find_boundary(const TriangleMesh& mesh, const MeshSurface& surface,
                           std::span<const std::uint32_t> piece_of_triangle);

}  // namespace orbweave
