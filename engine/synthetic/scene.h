// Scenes of known surfaces: a furnished room and a house with its grounds, made of triangles. What
// a scanner sees of a scene is the work of scene_scanner.h.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

enum class SceneKind {
  kRoom,   ///< seen from four tripods inside
  kHouse,  ///< seen from the air, along three lines of flight
  kFrames  ///< the room in five frames of a depth camera
};

/// "room", "house", "frames".
std::string_view name_of(SceneKind kind);
std::optional<SceneKind> scene_named(std::string_view name);
std::span<const SceneKind> all_scenes();

namespace synthetic {

enum class SceneRole : std::uint8_t {
  kSurface,  ///< stops rays, belongs to the truth
  kGlass,    ///< lets rays pass without a return, belongs to the truth
  kClutter   ///< stops rays, does not belong to the truth
};

/// Counterclockwise as seen from the air.
struct SceneTriangle {
  std::array<Vec3, 3> corners;
  SceneRole role = SceneRole::kSurface;
  std::uint8_t pane = 0;  ///< number of the window whose pane this is part of, from 1; 0: none
};

/// An upright cylinder that walks on a straight line while a scanner turns once.
struct Walker {
  std::size_t scan = 0;  ///< the scan that sees the walker
  Vec3 from, to;         ///< of the middle of the feet
  double radius = 0.0, height = 0.0;
};

/// A ball of leaves: a ray that crosses it may end at a leaf, and may end at a second thing behind.
struct Crown {
  Vec3 center;
  double radius = 0.0;
};

/// A straight line of flight; the scanner sweeps across it.
struct FlightLine {
  Vec3 begin, end;
  double half_angle_turns = 0.0;  ///< to each side of the vertical
};

/// Metres, z up.
struct Scene {
  std::vector<SceneTriangle> triangles;
  std::vector<Vec3> tripods;
  /// Where cameras at the places of the tripods look; empty: scanners that turn once around.
  std::vector<Vec3> targets;
  std::vector<FlightLine> lines;
  std::vector<Walker> walkers;
  std::vector<Crown> crowns;
};

Scene scene_of(SceneKind kind);
Scene room_scene();
Scene frames_scene();
Scene house_scene();

/// Of the surfaces that belong to the truth, panes included; square metres.
double truth_area(const Scene& scene);

/// The truth as a mesh: its triangles as they are, each with three vertices of its own, which have
/// the triangle's normal and the attribute `pane` (uint8).
TriangleMesh truth_mesh(const Scene& scene);

}  // namespace synthetic
}  // namespace orbweave
