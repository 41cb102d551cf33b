// Scans of terrestrial scanners in the vendor-neutral format E57 (ASTM E2807).
#pragma once

#include <memory>

#include "io/points/point_source.h"
#include "io/streams/random_access.h"

namespace orbweave {

/// Reads the points of all scans of an E57 file, scan by scan, each moved by its pose;
/// docs/e57.md says what becomes of which field. Memory: one batch, a window of pages, one packet
/// and the packets' bytes of the fields that are used. Throws Error (bad input) for what is no E57
/// file, for pages with a wrong checksum and for headers that contradict the file.
std::unique_ptr<PointSource> open_e57_source(std::unique_ptr<RandomAccess> file);

}  // namespace orbweave
