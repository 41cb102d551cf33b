// Where a surface goes on although its mesh ends.
#pragma once

#include <cstdint>

#include "io/triangle_mesh.h"

namespace orbweave {

/// How many boundary edges lie on another one that runs the other way between the same places. The
/// surface goes on there, but each side has vertices of its own, as files of other programs have
/// along sharp edges and the seams of textures. Precondition: indices are in range. Memory of an
/// EdgeTable, and 48 bytes per boundary edge; O(n log n).
std::uint64_t count_doubled_border(const TriangleMesh& mesh);

}  // namespace orbweave
