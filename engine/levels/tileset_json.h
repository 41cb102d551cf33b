// The document of a tileset.
#pragma once

#include <array>
#include <string>

#include "engine/levels/levels.h"

namespace orbweave {

/// Columns of a matrix, four numbers each.
using Transform = std::array<double, 16>;

/// Turns the axis that is upright to z, as 3D Tiles has it, and moves the origin to its place.
Transform upright_transform(int up_axis, Vec3 origin);

/// `origin`: of the tileset, which the places of tiles are counted from; `to_world`: from these
/// places to where the tileset lies.
std::string tileset_text(const Levels& levels, Vec3 origin, const Transform& to_world);

/// "000012.glb"
std::string tile_file(std::uint32_t node);

}  // namespace orbweave
