// What decides to which side of the surface estimated normals point.
#pragma once

#include <cstdint>

#include "engine/normals/orientation.h"
#include "io/surface_options.h"

namespace orbweave {

/// The first rule that applies: scanner, viewpoint, up direction, propagation. The same without the
/// up direction for Orientation::kGround, which stays where only propagation is left.
/// `points_without_view`: points whose scanner is not known.
Orientation side_of_normals(const NormalOptions& options, std::uint64_t points_without_view);

/// Whether the place of the scanner decides where it is known.
bool asks_for_scanner(Orientation rule);

/// Whether neighbours decide, by a rule that side_of_normals has returned.
bool is_propagated(Orientation rule);

/// How patches of `patches` are joined under a rule that is_propagated.
PatchGraphOptions graph_options(Orientation rule, const NormalOptions& options,
                                const OrientationOptions& patches);

}  // namespace orbweave
