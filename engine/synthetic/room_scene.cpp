// A furnished room of 6 by 5 metres under a sloped ceiling, with a pillar, windows of 0.12 to 1.8
// metres, and a door that stands open to a lobby.
#include <array>

#include "engine/synthetic/scene_builder.h"

namespace orbweave::synthetic {
namespace {

constexpr double kLength = 6.0, kWidth = 5.0;   ///< along x and y
constexpr double kLowSide = 2.4, kSlope = 0.2;  ///< height of the ceiling at y = 0; rise along y
constexpr double kReveal = 0.04, kVent = 0.02, kDoorway = 0.1;  ///< depths
/// A lobby behind the door: its ends along y, its depth, its height.
constexpr double kLobbyFrom = 1.1, kLobbyTo = 2.8, kLobbyDepth = 1.2, kLobbyHeight = 2.3;
constexpr std::array<Opening, 1> kDoor = {{{1.5, 0.0, 0.9, 2.05, kDoorway, false}}};

double ceiling(double y) { return kLowSide + kSlope * y; }

void add_shell(SceneBuilder& builder) {
  const double high = ceiling(kWidth);
  builder.add_quad({0, 0, 0}, {kLength, 0, 0}, {kLength, kWidth, 0}, {0, kWidth, 0});
  builder.add_quad({0, 0, kLowSide}, {0, kWidth, high}, {kLength, kWidth, high},
                   {kLength, 0, kLowSide});
  // At the height of the scanners, which see all four sides of most reveals.
  constexpr std::array<Opening, 6> kLowWall = {{{0.5, 1.42, 0.25, 0.25, kReveal},
                                                {1.1, 1.35, 0.4, 0.4, kReveal},
                                                {2.0, 1.2, 0.6, 0.6, kReveal},
                                                {3.1, 0.9, 1.2, 1.2, kReveal},
                                                {4.8, 1.2, 0.3, 0.6, kReveal},
                                                {5.6, 1.5, 0.12, 0.12, kVent}}};
  constexpr std::array<Opening, 4> kHighWall = {{{0.8, 1.3, 0.5, 0.4, kReveal},
                                                 {1.8, 1.3, 0.5, 0.4, kReveal},
                                                 {2.8, 2.3, 0.8, 0.5, kReveal},
                                                 {4.0, 1.0, 0.45, 0.9, kReveal}}};
  constexpr std::array<Opening, 4> kSide = {{{0.7, 0.8, 1.8, 1.3, kReveal},
                                             {3.2, 1.3, 0.5, 0.5, kReveal},
                                             {4.1, 1.4, 0.35, 0.35, kReveal},
                                             {4.7, 1.5, 0.15, 0.15, kVent}}};
  builder.add_wall({{kLength, 0, 0}, {0, 1, 0}, kLength, kLowSide}, kLowWall);
  builder.add_wall({{0, kWidth, 0}, {0, -1, 0}, kLength, high}, kHighWall);
  builder.add_wall({{kLength, kWidth, 0}, {-1, 0, 0}, kWidth, kLowSide}, kSide);
  builder.add_triangle({kLength, kWidth, kLowSide}, {kLength, 0, kLowSide},
                       {kLength, kWidth, high});
  builder.add_wall({{0, 0, 0}, {1, 0, 0}, kWidth, kLowSide}, kDoor);
  builder.add_triangle({0, 0, kLowSide}, {0, kWidth, kLowSide}, {0, kWidth, high});
}

void add_lobby(SceneBuilder& builder) {
  const double near = -kDoorway, far = near - kLobbyDepth, length = kLobbyTo - kLobbyFrom;
  builder.add_quad({far, kLobbyFrom, 0}, {near, kLobbyFrom, 0}, {near, kLobbyTo, 0},
                   {far, kLobbyTo, 0});
  builder.add_quad({far, kLobbyFrom, kLobbyHeight}, {far, kLobbyTo, kLobbyHeight},
                   {near, kLobbyTo, kLobbyHeight}, {near, kLobbyFrom, kLobbyHeight});
  const Opening& door = kDoor.front();
  const std::array<Opening, 1> from_behind = {
      {{kLobbyTo - door.left - door.width, 0.0, door.width, door.height, 0.0, false}}};
  builder.add_wall({{near, kLobbyTo, 0}, {-1, 0, 0}, length, kLobbyHeight}, from_behind);
  builder.add_wall({{far, kLobbyFrom, 0}, {1, 0, 0}, length, kLobbyHeight}, {});
  builder.add_wall({{near, kLobbyFrom, 0}, {0, 1, 0}, kLobbyDepth, kLobbyHeight}, {});
  builder.add_wall({{far, kLobbyTo, 0}, {0, -1, 0}, kLobbyDepth, kLobbyHeight}, {});
}

/// Four legs that stand on the floor under a board; `low` and `high`: the board.
void add_legs(SceneBuilder& builder, Vec3 low, Vec3 high, double side) {
  for (const double x : {low.x, high.x - side})
    for (const double y : {low.y, high.y - side})
      builder.add_box({x, y, 0}, {x + side, y + side, low.z}, kFaceAtC | kFaceBeyondC);
}

void add_chair(SceneBuilder& builder, Vec3 corner, bool back_at_low_y) {
  const Vec3 low{corner.x, corner.y, 0.43}, high{corner.x + 0.45, corner.y + 0.45, 0.46};
  builder.add_box(low, high);
  add_legs(builder, low, high, 0.04);
  const double y = back_at_low_y ? low.y : high.y - 0.04;
  builder.add_box({low.x, y, high.z}, {high.x, y + 0.04, 0.95}, kFaceAtC);
}

void add_furniture(SceneBuilder& builder) {
  const Vec3 low{3.2, 1.6, 0.71}, high{4.6, 2.4, 0.74};
  builder.add_box(low, high);
  add_legs(builder, low, high, 0.06);
  add_chair(builder, {3.4, 2.55, 0}, false);
  add_chair(builder, {3.9, 1.0, 0}, true);
  // A wardrobe, a bed with its pillow, a sofa.
  builder.add_box({4.7, 4.4, 0}, {5.8, kWidth, 2.0}, kFaceAtC | kFaceBeyondB);
  builder.add_box({0, 3.5, 0}, {1.9, kWidth, 0.45}, kFaceAtC | kFaceAtA | kFaceBeyondB);
  builder.add_box({0, 3.7, 0.45}, {0.4, 4.3, 0.55}, kFaceAtC | kFaceAtA);
  builder.add_box({0.5, 0, 0}, {2.3, 0.8, 0.42}, kFaceAtC | kFaceAtB);
  builder.add_box({0.5, 0, 0.42}, {2.3, 0.2, 0.78}, kFaceAtC | kFaceAtB);
  for (const double height : {0.25, 0.5, 0.75})
    builder.add_box({kLength - 0.3, 0.2, height}, {kLength, 1.2, height + 0.025}, kFaceBeyondA);
  // The leaf of the door, ajar, and a lamp that hangs on nothing.
  builder.add_block({{0.03, 2.42, 0.01}, {0.704, 0.528, 0}, {-0.024, 0.032, 0}, {0, 0, 2.0}});
  builder.add_ball({3.0, 2.5, 2.45}, 0.18, 32);
}

}  // namespace

Scene room_scene() {
  SceneBuilder builder;
  add_shell(builder);
  add_lobby(builder);
  builder.add_pillar(
      {2.2, 3.2, 0}, 0.18, 32, [](Vec3 p) { return ceiling(p.y); }, SceneRole::kSurface);
  add_furniture(builder);
  Scene scene = builder.scene;
  scene.tripods = {{1.2, 1.6, 1.5}, {5.2, 1.2, 1.6}, {4.4, 3.7, 1.55}, {2.6, 4.4, 1.5}};
  scene.walkers = {{1, {1.0, 2.7, 0}, {2.9, 3.0, 0}, 0.23, 1.75},
                   {2, {2.7, 0.9, 0}, {2.7, 3.0, 0}, 0.23, 1.75}};
  return scene;
}

Scene frames_scene() {
  Scene scene = room_scene();
  scene.walkers.clear();
  scene.tripods = {
      {0.8, 1.0, 1.5}, {1.2, 1.3, 1.45}, {1.6, 1.0, 1.4}, {1.3, 0.9, 1.6}, {2.0, 1.2, 1.5}};
  scene.targets = {
      {3.6, 2.6, 0.9}, {4.2, 2.4, 0.9}, {4.6, 3.0, 0.8}, {3.4, 3.4, 1.0}, {5.0, 2.2, 0.7}};
  return scene;
}

}  // namespace orbweave::synthetic
