// Text clouds (.xyz .xyzn .xyzrgb .asc .txt .csv .pts) as point sources.
#pragma once

#include <memory>

#include "io/clouds/text_layout.h"
#include "io/points/point_source.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

/// Opens a text cloud. Lines that are blank or begin with # or // are skipped. In a .pts
/// file, a line that is one whole number announces as many points, one such line before each scan;
/// a scan may have more points, one with fewer is an error. declared_points() is the first scan's
/// count. Throws Error as open_point_source does.
std::unique_ptr<PointSource> open_text_source(ByteReader reader, const TextOptions& options,
                                              TextKind kind);

}  // namespace orbweave
