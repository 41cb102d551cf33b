#include "engine/synthetic/scene_builder.h"

#include <algorithm>

#include "engine/synthetic/portable_math.h"

namespace orbweave::synthetic {
namespace {

constexpr Vec3 kUp{0.0, 0.0, 1.0};

/// The lines at which a wall is cut, so that openings are whole cells.
std::vector<double> cuts(double length, std::span<const Opening> openings, double Opening::*begin,
                         double Opening::*extent) {
  std::vector<double> places = {0.0, length};
  for (const Opening& opening : openings) {
    places.push_back(opening.*begin);
    places.push_back(opening.*begin + opening.*extent);
  }
  std::ranges::sort(places);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

bool is_open(double along, double up, std::span<const Opening> openings) {
  return std::ranges::any_of(openings, [&](const Opening& opening) {
    return along > opening.left && along < opening.left + opening.width && up > opening.bottom &&
           up < opening.bottom + opening.height;
  });
}

}  // namespace

void SceneBuilder::add_triangle(Vec3 a, Vec3 b, Vec3 c, SceneRole role) {
  scene.triangles.push_back({.corners = {a, b, c}, .role = role});
}

void SceneBuilder::add_quad(Vec3 a, Vec3 b, Vec3 c, Vec3 d, SceneRole role) {
  add_triangle(a, b, c, role);
  add_triangle(a, c, d, role);
}

void SceneBuilder::add_block(const Block& block, unsigned left_out, SceneRole role) {
  const auto& [corner, a, b, c] = block;
  const auto face = [&](unsigned which, Vec3 from, Vec3 u, Vec3 v) {
    if ((left_out & which) == 0) add_quad(from, from + u, from + u + v, from + v, role);
  };
  face(kFaceAtA, corner, c, b);
  face(kFaceBeyondA, corner + a, b, c);
  face(kFaceAtB, corner, a, c);
  face(kFaceBeyondB, corner + b, c, a);
  face(kFaceAtC, corner, b, a);
  face(kFaceBeyondC, corner + c, a, b);
}

void SceneBuilder::add_box(Vec3 low, Vec3 high, unsigned left_out) {
  const Vec3 size = high - low;
  add_block({low, {size.x, 0, 0}, {0, size.y, 0}, {0, 0, size.z}}, left_out);
}

void SceneBuilder::add_wall(const Wall& wall, std::span<const Opening> openings) {
  const Vec3 along = cross(kUp, wall.normal);
  const auto at = [&](double right, double up) { return wall.origin + right * along + up * kUp; };
  const std::vector<double> columns = cuts(wall.length, openings, &Opening::left, &Opening::width);
  const std::vector<double> rows = cuts(wall.height, openings, &Opening::bottom, &Opening::height);
  for (std::size_t i = 0; i + 1 < columns.size(); ++i)
    for (std::size_t j = 0; j + 1 < rows.size(); ++j) {
      const double left = columns[i], right = columns[i + 1], low = rows[j], high = rows[j + 1];
      if (is_open(0.5 * (left + right), 0.5 * (low + high), openings)) continue;
      add_quad(at(left, low), at(right, low), at(right, high), at(left, high));
    }
  for (const Opening& opening : openings) add_opening(wall, along, opening);
}

void SceneBuilder::add_opening(const Wall& wall, Vec3 along, const Opening& opening) {
  const Vec3 right = opening.width * along, up = opening.height * kUp;
  const Vec3 back = -opening.depth * wall.normal;
  const Vec3 corner = wall.origin + opening.left * along + opening.bottom * kUp;
  if (opening.depth == 0.0) return;
  add_quad(corner, corner + right, corner + right + back, corner + back);
  add_quad(corner + up, corner + up + back, corner + up + right + back, corner + up + right);
  add_quad(corner, corner + back, corner + back + up, corner + up);
  add_quad(corner + right, corner + right + up, corner + right + up + back, corner + right + back);
  if (!opening.has_pane) return;
  ++panes_;
  const std::size_t first = scene.triangles.size();
  const Vec3 pane = corner + back;
  add_quad(pane, pane + right, pane + right + up, pane + up, SceneRole::kGlass);
  for (std::size_t k = first; k < scene.triangles.size(); ++k) scene.triangles[k].pane = panes_;
}

Vec3 SceneBuilder::on_circle(Vec3 center, double radius, int k, int sides) {
  const portable::SineCosine angle =
      portable::sine_cosine(static_cast<double>(k % sides) / static_cast<double>(sides));
  return center + radius * Vec3{angle.cosine, angle.sine, 0.0};
}

void SceneBuilder::add_ball(Vec3 center, double radius, int meridians) {
  const int rows = meridians / 2;
  const auto at = [&](int k, int row) {
    const portable::SineCosine height =
        portable::sine_cosine(0.5 * static_cast<double>(row) / rows - 0.25);
    return on_circle(center + radius * height.sine * kUp, radius * height.cosine, k, meridians);
  };
  for (int row = 0; row < rows; ++row)
    for (int k = 0; k < meridians; ++k) {
      if (row > 0) add_triangle(at(k, row), at(k + 1, row), at(k + 1, row + 1));
      if (row + 1 < rows) add_triangle(at(k, row), at(k + 1, row + 1), at(k, row + 1));
    }
}

}  // namespace orbweave::synthetic
