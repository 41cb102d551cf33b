#include "engine/holes/small_pieces.h"

#include <algorithm>
#include <utility>

#include "engine/holes/hole_pass.h"
#include "io/keep_points.h"

namespace orbweave {

MeshSurvey::MeshSurvey(const TriangleMesh& mesh)
    : surface(mesh),
      unusual(unusual_vertices(mesh, surface)),
      components(find_components(mesh, surface, unusual)) {}

std::vector<std::uint8_t> small_pieces(const TriangleMesh& mesh, const MeshSurvey& survey,
                                       const FillOptions& options, const StopToken* stop) {
  const std::vector<Piece>& pieces = survey.components.pieces;
  std::uint64_t largest = 0;
  for (const Piece& piece : pieces) largest = std::max(largest, piece.triangles);
  const std::uint64_t min_triangles = least_triangles(options, largest);
  std::vector<std::uint8_t> is_removed;
  for (const Piece& piece : pieces) is_removed.push_back(piece.triangles < min_triangles ? 1 : 0);
  if (options.min_triangles || pieces.size() < 2) return is_removed;
  const std::vector<std::uint32_t>& piece_of = survey.components.of_triangle;
  std::vector<std::uint8_t> keep;
  for (const std::uint32_t piece : piece_of) keep.push_back(is_removed[piece] == 0 ? 1 : 0);
  MeshBoundary boundary = find_boundary(mesh, MeshSurface(mesh, keep), survey.unusual, piece_of);
  for (BoundaryVertex& known : boundary.vertices)
    known.normal = mesh.vertices.normals[known.vertex];
  const HolePlan plan =
      plan_holes(std::move(boundary.fans), std::move(boundary.vertices), pieces, options, stop);
  for (std::size_t p = 0; p < is_removed.size(); ++p) is_removed[p] |= plan.crumbs[p];
  return is_removed;
}

TriangleMesh without_pieces(TriangleMesh mesh, const MeshComponents& components,
                            std::span<const std::uint8_t> is_removed) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (is_removed[components.of_triangle[t]] == 0) mesh.triangles[kept++] = mesh.triangles[t];
  mesh.triangles.resize(kept);
  return used_part(std::move(mesh.vertices), std::move(mesh.triangles));
}

TriangleMesh used_part(PointCloud points, std::vector<Triangle> triangles) {
  std::vector<std::uint8_t> used(points.size(), 0);
  for (const Triangle& t : triangles)
    for (const std::uint32_t vertex : t) used[vertex] = 1;
  if (std::find(used.begin(), used.end(), 0) == used.end())
    return {std::move(points), std::move(triangles), {}};
  std::vector<std::uint32_t> number(points.size());
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < used.size(); ++i) number[i] = used[i] != 0 ? count++ : 0;
  for (Triangle& t : triangles)
    for (std::uint32_t& vertex : t) vertex = number[vertex];
  keep_points(used, points);
  return {std::move(points), std::move(triangles), {}};
}

}  // namespace orbweave
