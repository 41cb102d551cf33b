// Which Voronoi cells of a part of a cloud are cells of the whole cloud.
// Dey, Giesen, Hudson, Delaunay Based Shape Reconstruction from Large Data, 2001.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/voronoi/tetrahedra.h"
#include "io/box.h"
#include "io/stop_token.h"

namespace orbweave::voronoi {

/// What is known of a cloud where only a part of it is at hand.
struct KnownPart {
  Box box;    ///< all points of the cloud in it are at hand
  Box cloud;  ///< around the whole cloud
};

/// 1 per point whose Voronoi cell is that of the whole cloud: every ball around a corner of the
/// cell that touches the point, as far as it lies in the cloud's box, lies in the box that is
/// known, and so does what is beyond every facet of the hull at the point. Others may be cells of
/// the whole cloud as well. `tetrahedra`: with centres, of the points at hand. O(tetrahedra).
std::vector<std::uint8_t> certified_cells(std::span<const Vec3> points,
                                          const Tetrahedra& tetrahedra, const KnownPart& part,
                                          const StopToken* stop = nullptr);

}  // namespace orbweave::voronoi
