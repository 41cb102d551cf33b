#include "engine/geometry/vector_width.h"

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

}  // namespace orbweave
