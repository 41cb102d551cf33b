#include "engine/pipeline/surface/filled_holes.h"

#include <algorithm>

namespace orbweave {

const SplitCorner* find_split(const FilledHoles& holes, const Triangle64& triangle,
                              std::uint64_t vertex) {
  const auto at = std::lower_bound(holes.splits.begin(), holes.splits.end(),
                                   SplitCorner{triangle, vertex, CopyIndex{}});
  const bool found = at != holes.splits.end() && at->triangle == triangle && at->vertex == vertex;
  return found ? &*at : nullptr;
}

}  // namespace orbweave
