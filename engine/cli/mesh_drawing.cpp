#include "engine/cli/mesh_drawing.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/geometry/edge_components.h"
#include "io/bounds.h"
#include "io/report/picture_palette.h"
#include "io/report/point_colors.h"

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

/// The colours of all fronts; empty where filled holes alone are told apart.
struct FrontColors {
  std::vector<Rgb> fronts;
  std::vector<LegendEntry> legend;
};

FrontColors colors_of_components(const TriangleMesh& mesh) {
  EdgeComponents components;
  components.add(mesh.triangles, [](std::uint32_t vertex) { return std::uint64_t{vertex}; });
  components.finish();
  FrontColors colors;
  colors.fronts.reserve(mesh.triangles.size());
  for (const std::uint32_t rank : components.ranks(0, mesh.triangles))
    colors.fronts.push_back(component_color(rank));
  colors.legend = component_legend(components.triangles());
  return colors;
}

/// A triangle has the colour of its first vertex, one that fills a hole that of filled holes.
FrontColors colors_of_points(const TriangleMesh& mesh, const MeshDrawing& drawing) {
  FrontColors colors;
  PointColors points(mesh.vertices.schema);
  if (!points.any()) return colors;
  if (points.needs_survey()) points.survey(mesh.vertices);
  points.finish();
  colors.fronts.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const bool fills = !mesh.hole.empty() && mesh.hole[i] > 0;
    colors.fronts.push_back(fills ? drawing.picture.patch_color
                                  : points.of(mesh.vertices, mesh.triangles[i][0]));
  }
  colors.legend = {points.legend()};
  return colors;
}

FrontColors front_colors(const TriangleMesh& mesh, const MeshDrawing& drawing) {
  const bool has_patches =
      std::ranges::any_of(mesh.hole, [](std::int32_t hole) { return hole > 0; });
  FrontColors colors;
  if (drawing.colors == PictureColors::kComponent) return colors_of_components(mesh);
  if (drawing.colors == PictureColors::kPoints) colors = colors_of_points(mesh, drawing);
  std::vector<LegendEntry> usual = surface_legend(drawing.picture, has_patches);
  if (!colors.legend.empty()) usual.front() = colors.legend.front();
  colors.legend = std::move(usual);
  return colors;
}

}  // namespace

void draw_mesh(const TriangleMesh& mesh, const std::string& path, const MeshDrawing& drawing) {
  const std::span<const std::int32_t> hole(mesh.hole);
  FrontColors colors = front_colors(mesh, drawing);
  const std::span<const Rgb> fronts(colors.fronts);
  MeshPicture picture(bounds_of_surface(mesh.vertices.positions, mesh.triangles), drawing.picture);
  picture.set_legend(std::move(colors.legend));
  if (drawing.backs == PictureBacks::kCulled) picture.leave_out_backs();
  const auto draw = [&] {
    for_each_batch(mesh,
                   [&](const std::vector<Corners>& corners, std::size_t first, std::size_t count) {
                     if (!fronts.empty())
                       picture.draw_colored(corners, fronts.subspan(first, count));
                     else
                       picture.draw(corners, hole.empty() ? hole : hole.subspan(first, count));
                   });
  };
  draw();
  if (drawing.backs == PictureBacks::kAuto) picture.look_at_fronts(false, draw);
  picture.show_specks(draw);
  picture.write_png(path);
}

void draw_mesh_by_shares(const TriangleMesh& mesh, std::span<const float> shares,
                         const std::string& large, const std::string& path,
                         const PictureOptions& options) {
  MeshPicture picture(bounds_of_surface(mesh.vertices.positions, mesh.triangles), options);
  picture.set_legend(share_legend(large));
  const auto draw = [&] {
    for_each_batch(mesh,
                   [&](const std::vector<Corners>& corners, std::size_t first, std::size_t count) {
                     picture.draw_shares(corners, shares.subspan(first, count));
                   });
  };
  draw();
  picture.look_at_fronts(false, draw);
  picture.show_specks(draw);
  picture.write_png(path);
}

}  // namespace orbweave
