// The walk on eight lanes; compiled for AVX-512, chosen at run time.
#define ORBWEAVE_SIMD_AVX512
#include "engine/ball_pivoting/walk_kernel.inl"

namespace orbweave {

void walk_avx512(const PointArrays& points, const CandidateRanges& candidates, std::uint32_t first,
                 std::uint32_t count, double ball_radius, const std::uint8_t* active,
                 const WalkScratch* scratch, Fan* fans) {
  walk(points, candidates, first, count, ball_radius, active, scratch, fans);
}

}  // namespace orbweave
