// Searches for machines without wider vectors, and the choice of the form.
#include "engine/geometry/neighbor_kernel.inl"

namespace orbweave {

NeighborKernel neighbor_kernel_generic() { return kKernel; }

NeighborKernel neighbor_kernel(VectorWidth width) {
#if defined(ORBWEAVE_X86)
  if (width == VectorWidth::kAvx512) return neighbor_kernel_avx512();
  if (width == VectorWidth::kAvx2) return neighbor_kernel_avx2();
#endif
  (void)width;
  return neighbor_kernel_generic();
}

}  // namespace orbweave
