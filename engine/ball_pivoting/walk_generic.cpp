// The walk, one point at a time: the form for machines without wider vectors.
#include "engine/ball_pivoting/walk_kernel.inl"

namespace orbweave {

void walk_generic(const PointArrays& points, const CandidateRanges& candidates, std::uint32_t first,
                  std::uint32_t count, double ball_radius, const std::uint8_t* active,
                  const WalkScratch* scratch, Fan* fans) {
  walk(points, candidates, first, count, ball_radius, active, scratch, fans);
}

}  // namespace orbweave
