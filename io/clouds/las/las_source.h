// LAS files, and LAZ files through their decoder, as point sources.
#pragma once

#include <memory>

#include "io/points/point_source.h"
#include "io/streams/random_access.h"

namespace orbweave {

/// The points of a LAS file, version 1.0 to 1.4, point format 0 to 10, compressed or not; what
/// becomes of its fields is told in docs/las.md. Points marked as withheld are left out, with that
/// word as the reason. Throws Error (bad input) with file, byte and field where the header or the
/// compressed data is damaged and where the file is too short for the points it promises.
std::unique_ptr<PointSource> open_las_source(std::unique_ptr<RandomAccess> file);

}  // namespace orbweave
