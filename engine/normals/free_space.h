// What lies on both sides of a part of a cloud, as rays from its patches find it. A scanner has
// seen a surface across free space, and what is solid is thinner than that: the two sides of a
// board, a wall between rooms, a bowl.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "engine/normals/orientation_graph.h"
#include "engine/normals/patch_sums.h"
#include "io/stop_token.h"

namespace orbweave {

/// Areas as sampled, world units squared. Front: where a part's normals point, as oriented now.
struct PartSpace {
  double area = 0.0;
  double shut = 0.0;           ///< of patches shut in on both sides
  double farther_front = 0.0;  ///< of them, where front is the wider side
  double farther_back = 0.0;   ///< and where back is by far the wider side, and front is cut off
  std::uint64_t cut_off = 0;   ///< how many of the latter
  double open_front = 0.0;     ///< of rays to the front, those that leave the cloud
  double open_back = 0.0;      ///< of rays to the back
};

/// Rays from one part that meet another first: > 0 where both show each other the same side.
struct Facing {
  std::uint32_t from = 0;  ///< parts, by their smallest row
  std::uint32_t to = 0;
  double votes = 0.0;  ///< area; positive where both show the other one front, or both back
  double front = 0.0;  ///< area, of the rays that leave `from` at its front
  double weight = 0.0;
};

struct SpaceOfParts {
  std::vector<PartSpace> of_part;  ///< by the part's smallest row; empty where it was not sampled
  std::vector<Facing> facing;      ///< by (from, to)
};

/// Rows of parts, ascending, by the part's smallest row; none without an area.
using RowsOfParts = std::map<std::uint32_t, std::vector<std::uint32_t>>;

/// Samples the parts of `rows`, the larger ones more densely; some ten thousand rays in all.
/// `turn`: of patches, on top of their sums. The result depends on the rows' order alone. Runs on
/// the calling TBB arena.
SpaceOfParts find_free_space(std::span<const PatchSum> sums, double cell,
                             std::span<const std::uint32_t> part,
                             std::span<const std::uint8_t> turn, const RowsOfParts& rows,
                             const StopToken* stop = nullptr);

}  // namespace orbweave
