// PLY files as point sources.
#pragma once

#include <memory>

#include "io/points/point_source.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

/// The vertices of a PLY file. Throws Error (bad input) when the header is damaged, when it has
/// no vertices with x, y and z, and when the file is too short for it.
std::unique_ptr<PointSource> open_ply_source(ByteReader reader);

}  // namespace orbweave
