#include "engine/geometry/block_scan.h"

namespace orbweave {

void scan_block_generic(const double* x, const double* y, const double* z, double px, double py,
                        double pz, double limit, NearInBlock& found) {
  for (std::uint32_t j = 0; j < kPointsPerBlock; ++j) {
    const double dx = x[j] - px, dy = y[j] - py, dz = z[j] - pz;
    found.squared[j] = dx * dx + dy * dy + dz * dz;
  }
  // Listed without a branch: which points are near is hard to predict.
  found.count = 0;
  for (std::uint32_t j = 0; j < kPointsPerBlock; ++j) {
    found.listed[found.count] = j;
    found.count += found.squared[j] <= limit;
  }
}

BlockScan block_scan() {
#if defined(ORBWEAVE_X86)
  if (__builtin_cpu_supports("avx2")) return scan_block_avx2;
#endif
  return scan_block_generic;
}

}  // namespace orbweave
