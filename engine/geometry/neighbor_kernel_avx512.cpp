// Searches on eight lanes; compiled for AVX-512, chosen at run time.
#define ORBWEAVE_SIMD_AVX512
#include "engine/geometry/neighbor_kernel.inl"

namespace orbweave {

NeighborKernel neighbor_kernel_avx512() { return kKernel; }

}  // namespace orbweave
