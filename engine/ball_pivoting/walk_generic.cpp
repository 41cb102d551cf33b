// The walk, one point at a time: the form for machines without wider vectors.
#include "engine/ball_pivoting/walk_kernel.inl"

namespace orbweave {

void walk_generic(const PointArrays& points, const CandidateRanges& candidates, std::uint32_t point,
                  double ball_radius, const std::uint8_t* active, const WalkScratch& scratch,
                  Fan& fan) {
  walk(points, candidates, point, ball_radius, active, scratch, fan);
}

}  // namespace orbweave
