// What decides to which side of the surface estimated normals point.
#pragma once

#include <cstdint>

#include "io/surface_options.h"

namespace orbweave {

/// The first rule that applies: scanner, viewpoint, up direction, propagation.
/// `points_without_view`: points whose scanner is not known.
Orientation side_of_normals(const NormalOptions& options, std::uint64_t points_without_view);

}  // namespace orbweave
