// Text clouds (.xyz .txt .csv .pts) as point sources.
#pragma once

#include <memory>

#include "io/byte_reader.h"
#include "io/point_source.h"

namespace orbweave {

/// Opens a text cloud. `is_pts`: its first line may be the number of points. Lines that are blank
/// or begin with # or // are skipped. Throws Error as open_point_source does.
std::unique_ptr<PointSource> open_text_source(ByteReader reader, const TextOptions& options,
                                              bool is_pts);

}  // namespace orbweave
