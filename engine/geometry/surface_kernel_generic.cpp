// Neighbourhoods for machines without wider vectors, and the choice of the form.
#include "engine/geometry/surface_kernel.inl"
#include "engine/geometry/vector_width.h"

namespace orbweave {

SurfaceKernel surface_kernel_generic() { return kKernel; }

const SurfaceKernel& surface_kernel() {
#if defined(ORBWEAVE_X86)
  static const SurfaceKernel kernel =
      widest_supported() != VectorWidth::kScalar ? surface_kernel_avx2() : surface_kernel_generic();
#else
  static const SurfaceKernel kernel = surface_kernel_generic();
#endif
  return kernel;
}

}  // namespace orbweave
