#include "engine/cli/mesh_drawing.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace orbweave {

void draw_mesh(const TriangleMesh& mesh, const Box& bounds, const std::string& path,
               const PictureOptions& options) {
  constexpr std::size_t kBatchTriangles = std::size_t{1} << 16;
  const std::vector<Vec3>& at = mesh.vertices.positions;
  const std::span<const std::int32_t> hole(mesh.hole);
  MeshPicture picture(bounds, options);
  std::vector<std::array<Vec3, 3>> corners;
  for (std::size_t first = 0; first < mesh.triangles.size(); first += kBatchTriangles) {
    const std::size_t count = std::min(kBatchTriangles, mesh.triangles.size() - first);
    corners.clear();
    for (std::size_t i = first; i < first + count; ++i) {
      const Triangle& t = mesh.triangles[i];
      corners.push_back({at[t[0]], at[t[1]], at[t[2]]});
    }
    picture.draw(corners, hole.empty() ? hole : hole.subspan(first, count));
  }
  picture.write_png(path);
}

}  // namespace orbweave
