#include "engine/ball_pivoting/walk.h"

namespace orbweave {

VectorWidth widest_supported() {
#if defined(ORBWEAVE_X86)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    return VectorWidth::kAvx512;
  }
  if (__builtin_cpu_supports("avx2")) return VectorWidth::kAvx2;
#endif
  return VectorWidth::kScalar;
}

WalkKernel walk_kernel(VectorWidth width) {
#if defined(ORBWEAVE_X86)
  if (width == VectorWidth::kAvx512) return walk_kernel_avx512();
  if (width == VectorWidth::kAvx2) return walk_kernel_avx2();
#endif
  (void)width;
  return walk_kernel_generic();
}

}  // namespace orbweave
