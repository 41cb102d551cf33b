// Neighbourhoods on four lanes; compiled for AVX2, chosen at run time.
#include "engine/geometry/surface_kernel.inl"

namespace orbweave {

SurfaceKernel surface_kernel_avx2() { return kKernel; }

}  // namespace orbweave
