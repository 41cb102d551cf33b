#include "engine/ball_pivoting/walk.h"

namespace orbweave {

WalkKernel walk_kernel(VectorWidth width) {
#if defined(ORBWEAVE_X86)
  if (width == VectorWidth::kAvx512) return walk_kernel_avx512();
  if (width == VectorWidth::kAvx2) return walk_kernel_avx2();
#endif
  (void)width;
  return walk_kernel_generic();
}

}  // namespace orbweave
