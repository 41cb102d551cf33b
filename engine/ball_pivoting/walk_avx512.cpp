// The walk on eight lanes; compiled for AVX-512, chosen at run time.
#define ORBWEAVE_SIMD_AVX512
#include "engine/ball_pivoting/walk_kernel.inl"

namespace orbweave {

WalkKernel walk_kernel_avx512() { return {gather, gather_crowd, walk, suspect, confirm}; }

}  // namespace orbweave
