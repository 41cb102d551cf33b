// The document of a tileset.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "engine/levels/levels.h"
#include "engine/levels/listed_holes.h"
#include "io/vertex_values.h"

namespace orbweave {

/// Columns of a matrix, four numbers each.
using Transform = std::array<double, 16>;

/// Turns the axis that is upright to z, as 3D Tiles has it, and moves the origin to its place.
Transform upright_transform(int up_axis, Vec3 origin);

/// What is said of the faces of the whole mesh.
struct TaggedFaces {
  std::span<const ListedHole> holes;
  std::uint64_t hole_count = 0;  ///< of all that are filled
  bool has_confidence = false;
  std::span<const std::uint64_t> components;  ///< triangles of each, the largest first
};

/// `values`: what vertices tell of their points. `origin`: of the tileset, which the places of
/// tiles are counted from; `to_world`: from these places to where the tileset lies.
std::string tileset_text(const Levels& levels, const TaggedFaces& faces,
                         std::span<const ShownRange> values, Vec3 origin,
                         const Transform& to_world);

/// "000012.glb"
std::string tile_file(std::uint32_t node);

}  // namespace orbweave
