// A house with a gable roof, a shed and a garden wall among trees, on rolling ground of 60 by 60
// metres, seen from the air.
#include <algorithm>
#include <array>
#include <cmath>

#include "engine/synthetic/portable_math.h"
#include "engine/synthetic/scene_builder.h"

namespace orbweave::synthetic {
namespace {

constexpr int kReach = 30;  ///< of the ground on each side of the middle
constexpr double kX = 6.0, kY = 4.0, kWallHeight = 5.0;  ///< half the house's length and width
constexpr double kSlope = 0.8, kEaves = 0.7, kGableOverhang = 0.6, kThickness = 0.2;  ///< roof
constexpr double kAltitude = 120.0;

/// Whole metres, so that cells of the ground end at the walls.
struct Footprint {
  double low_x, low_y, high_x, high_y;
};
constexpr std::array<Footprint, 2> kBuildings = {{{-kX, -kY, kX, kY}, {12, 6, 16, 9}}};

double distance_to_buildings(double x, double y) {
  double least = 2.0 * kReach;
  for (const Footprint& f : kBuildings) {
    const double dx = std::max({f.low_x - x, 0.0, x - f.high_x});
    const double dy = std::max({f.low_y - y, 0.0, y - f.high_y});
    least = std::min(least, std::sqrt(dx * dx + dy * dy));
  }
  return least;
}

/// Level around the buildings.
double ground(double x, double y) {
  const double share = std::clamp((distance_to_buildings(x, y) - 1.0) / 6.0, 0.0, 1.0);
  const double wave = portable::sine_cosine(x / 37.0).sine * portable::sine_cosine(y / 29.0).cosine;
  return share * (0.03 * x + 0.6 * wave);
}

Vec3 on_ground(double x, double y) { return {x, y, ground(x, y)}; }

void add_ground(SceneBuilder& builder) {
  for (int i = -kReach; i < kReach; ++i)
    for (int j = -kReach; j < kReach; ++j) {
      if (distance_to_buildings(i + 0.5, j + 0.5) == 0.0) continue;
      builder.add_quad(on_ground(i, j), on_ground(i + 1, j), on_ground(i + 1, j + 1),
                       on_ground(i, j + 1));
    }
}

void add_walls(SceneBuilder& builder) {
  constexpr double kReveal = 0.1;
  constexpr std::array<Opening, 4> kFront = {{{1.0, 1.0, 1.2, 1.4, kReveal},
                                              {4.0, 1.0, 1.2, 1.4, kReveal},
                                              {7.5, 0.9, 2.4, 1.5, kReveal},
                                              {4.0, 3.2, 1.0, 1.2, kReveal}}};
  constexpr std::array<Opening, 2> kGable = {
      {{2.0, 1.0, 1.2, 1.4, kReveal}, {5.0, 1.0, 1.2, 1.4, kReveal}}};
  builder.add_wall({{-kX, -kY, 0}, {0, -1, 0}, 2 * kX, kWallHeight}, kFront);
  builder.add_wall({{kX, kY, 0}, {0, 1, 0}, 2 * kX, kWallHeight}, kFront);
  builder.add_wall({{kX, -kY, 0}, {1, 0, 0}, 2 * kY, kWallHeight}, kGable);
  builder.add_wall({{-kX, kY, 0}, {-1, 0, 0}, 2 * kY, kWallHeight}, kGable);
  const double top = kWallHeight + kSlope * kY;
  builder.add_triangle({kX, -kY, kWallHeight}, {kX, kY, kWallHeight}, {kX, 0, top});
  builder.add_triangle({-kX, kY, kWallHeight}, {-kX, -kY, kWallHeight}, {-kX, 0, top});
}

/// One half of the roof; `side`: -1 or 1, towards which it falls. Its underside is there where it
/// overhangs the walls.
void add_roof(SceneBuilder& builder, double side) {
  const double left = -side * -(kX + kGableOverhang), right = -left;  // as seen from outside
  const auto under = [&](double x, double from_ridge) {
    return Vec3{x, side * from_ridge, kWallHeight + kSlope * (kY - from_ridge)};
  };
  const auto over = [&](double x, double from_ridge) {
    return under(x, from_ridge) + Vec3{0, 0, kThickness};
  };
  const double eaves = kY + kEaves, wall = left > 0 ? kX : -kX;
  builder.add_quad(over(left, eaves), over(right, eaves), over(right, 0), over(left, 0));
  builder.add_quad(under(left, eaves), under(right, eaves), over(right, eaves), over(left, eaves));
  builder.add_quad(under(left, eaves), over(left, eaves), over(left, 0), under(left, 0));
  builder.add_quad(under(right, eaves), under(right, 0), over(right, 0), over(right, eaves));
  builder.add_quad(under(left, eaves), under(left, kY), under(right, kY), under(right, eaves));
  builder.add_quad(under(left, kY), under(left, 0), under(wall, 0), under(wall, kY));
  builder.add_quad(under(-wall, kY), under(-wall, 0), under(right, 0), under(right, kY));
}

void add_tree(SceneBuilder& builder, Vec3 foot, double height, double radius) {
  const Vec3 center{foot.x, foot.y, foot.z + height};
  builder.scene.crowns.push_back({center, radius});
  builder.add_pillar(
      foot, 0.25, 8, [&](Vec3) { return center.z; }, SceneRole::kClutter);
}

}  // namespace

Scene house_scene() {
  SceneBuilder builder;
  add_ground(builder);
  add_walls(builder);
  add_roof(builder, -1.0);
  add_roof(builder, 1.0);
  builder.add_box({2.0, -1.4, 7.2}, {2.6, -0.8, 9.0}, kFaceAtC);  // chimney
  const Footprint& shed = kBuildings[1];
  builder.add_box({shed.low_x, shed.low_y, 0}, {shed.high_x, shed.high_y, 2.6}, kFaceAtC);
  builder.add_box({-20, -14, -1.0}, {-9, -13.7, 1.6}, kFaceAtC);  // garden wall
  add_tree(builder, on_ground(-14, 10), 6.0, 2.8);
  add_tree(builder, on_ground(10, -14), 5.0, 2.2);
  add_tree(builder, on_ground(8.5, 3), 6.0, 2.4);
  add_tree(builder, on_ground(-3, 17), 4.5, 2.0);
  const double half_angle = 20.0 / 360.0;
  builder.scene.lines = {{{-kReach, -12, kAltitude}, {kReach, -12, kAltitude}, half_angle},
                         {{kReach, 12, kAltitude}, {-kReach, 12, kAltitude}, half_angle},
                         {{5, -kReach, kAltitude}, {5, kReach, kAltitude}, half_angle}};
  return builder.scene;
}

}  // namespace orbweave::synthetic
