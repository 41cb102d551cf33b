// The walk on four lanes; compiled for AVX2, chosen at run time.
#define ORBWEAVE_SIMD_AVX2
#include "engine/ball_pivoting/walk_kernel.inl"

namespace orbweave {

WalkKernel walk_kernel_avx2() { return {gather, gather_crowd, walk, suspect, confirm}; }

}  // namespace orbweave
