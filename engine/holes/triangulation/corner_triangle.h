// Triangles between the corners of a loop, and chords that they must not use.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

namespace orbweave {

/// Corners of a loop, 0 to n - 1 in its order, then interior points. Corners that are the same
/// vertex of the mesh are different corners here: patches are discs of corners.
using CornerTriangle = std::array<std::uint32_t, 3>;

/// A chord between two corners that must not be used.
using ForbiddenChord = std::function<bool(std::uint32_t, std::uint32_t)>;

}  // namespace orbweave
