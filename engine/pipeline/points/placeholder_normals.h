// Normals that a scan has in name alone.
#pragma once

#include <optional>

#include "engine/pipeline/stage/partition.h"
#include "io/stop_token.h"
#include "io/store/chunk_store.h"
#include "io/vec3.h"

namespace orbweave {

/// The normal that all points of the scan have, although they lie in no plane across it: columns of
/// a text file that are something else, or that a program has filled with one value. Nothing where
/// two points differ, or the points have no normals. Looks at all points, after some thousand of
/// which in most scans two differ. The same for any cut.
std::optional<Vec3> placeholder_normal(const ChunkStore& store, const Partition& partition,
                                       const StopToken& stop);

}  // namespace orbweave
