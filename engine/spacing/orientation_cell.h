// The cells that the points of a cloud are oriented in (engine/normals/orientation.h).
#pragma once

namespace orbweave {

/// Side of a cell for points of such a spacing: a power of two, world units. A cell holds some 150
/// to 600 points of a surface. The same on every machine.
double orientation_cell(double spacing);

}  // namespace orbweave
