// What a job selects of the points of its scans, as options of the source that selects.
#pragma once

#include <memory>

#include "io/clouds/scan_source.h"
#include "io/job/job.h"

namespace orbweave {

/// Whether the area is in a file of its own.
bool names_area_file(const InputOptions& input);

/// The area of the crop; null where there is none. Reads its file. Throws Error (bad input).
std::shared_ptr<const PolygonArea> area_of(const InputOptions& input);

/// The options of a scan source that say which points are wanted, and no others.
ScanOptions selection_of(const InputOptions& input, std::shared_ptr<const PolygonArea> area);

}  // namespace orbweave
