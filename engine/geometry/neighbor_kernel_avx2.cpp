// Searches on four lanes; compiled for AVX2, chosen at run time.
#define ORBWEAVE_SIMD_AVX2
#include "engine/geometry/neighbor_kernel.inl"

namespace orbweave {

NeighborKernel neighbor_kernel_avx2() { return kKernel; }

}  // namespace orbweave
