#include "engine/cli/mesh_drawing.h"

#include <algorithm>
#include <array>
#include <vector>

namespace orbweave {
namespace {

using Corners = std::array<Vec3, 3>;

/// Calls draw(corners, first, count) for one batch of triangles after another.
template <class Draw>
void for_each_batch(const TriangleMesh& mesh, const Draw& draw) {
  constexpr std::size_t kBatchTriangles = std::size_t{1} << 16;
  const std::vector<Vec3>& at = mesh.vertices.positions;
  std::vector<Corners> corners;
  for (std::size_t first = 0; first < mesh.triangles.size(); first += kBatchTriangles) {
    const std::size_t count = std::min(kBatchTriangles, mesh.triangles.size() - first);
    corners.clear();
    for (std::size_t i = first; i < first + count; ++i) {
      const Triangle& t = mesh.triangles[i];
      corners.push_back({at[t[0]], at[t[1]], at[t[2]]});
    }
    draw(corners, first, count);
  }
}

}  // namespace

void draw_mesh(const TriangleMesh& mesh, const Box& bounds, const std::string& path,
               const PictureOptions& options, bool culls_backs) {
  const std::span<const std::int32_t> hole(mesh.hole);
  MeshPicture picture(bounds, options);
  if (culls_backs) picture.leave_out_backs();
  for_each_batch(mesh,
                 [&](const std::vector<Corners>& corners, std::size_t first, std::size_t count) {
                   picture.draw(corners, hole.empty() ? hole : hole.subspan(first, count));
                 });
  picture.write_png(path);
}

void draw_mesh_by_shares(const TriangleMesh& mesh, std::span<const float> shares,
                         const std::string& path, const PictureOptions& options) {
  MeshPicture picture(mesh.vertices.bounds(), options);
  for_each_batch(mesh,
                 [&](const std::vector<Corners>& corners, std::size_t first, std::size_t count) {
                   picture.draw_shares(corners, shares.subspan(first, count));
                 });
  picture.write_png(path);
}

}  // namespace orbweave
