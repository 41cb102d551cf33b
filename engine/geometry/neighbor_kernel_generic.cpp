// Searches for machines without wider vectors, and the choice of the form.
#include "engine/geometry/neighbor_kernel.inl"

namespace orbweave {

NeighborKernel neighbor_kernel_generic() { return kKernel; }

const NeighborKernel& neighbor_kernel() {
#if defined(ORBWEAVE_X86)
  static const NeighborKernel kernel =
      __builtin_cpu_supports("avx2") ? neighbor_kernel_avx2() : neighbor_kernel_generic();
#else
  static const NeighborKernel kernel = neighbor_kernel_generic();
#endif
  return kernel;
}

}  // namespace orbweave
