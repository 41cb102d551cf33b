// Attributes that the program adds to those of the scans.
#pragma once

#include "io/point_cloud.h"

namespace orbweave {

/// Adds an attribute of the program's own behind those of the scans. An attribute of a scan that
/// has its name becomes scan_NAME, or scan_NAME_2, ... where the scan has that as well.
void add_own_attribute(PointSchema& schema, const AttributeField& own);

}  // namespace orbweave
