// Four points at once; compiled for AVX2, chosen at run time.
#include <immintrin.h>

#include "engine/geometry/block_scan.h"

namespace orbweave {
namespace {

/// For each mask of four lanes the lanes of it, in order.
constexpr std::int32_t kLanes[16][4] = {{0, 0, 0, 0}, {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0},
                                        {2, 0, 0, 0}, {0, 2, 0, 0}, {1, 2, 0, 0}, {0, 1, 2, 0},
                                        {3, 0, 0, 0}, {0, 3, 0, 0}, {1, 3, 0, 0}, {0, 1, 3, 0},
                                        {2, 3, 0, 0}, {0, 2, 3, 0}, {1, 2, 3, 0}, {0, 1, 2, 3}};

}  // namespace

void scan_block_avx2(const double* x, const double* y, const double* z, double px, double py,
                     double pz, double limit, NearInBlock& found) {
  const __m256d px4 = _mm256_set1_pd(px), py4 = _mm256_set1_pd(py), pz4 = _mm256_set1_pd(pz);
  const __m256d limit4 = _mm256_set1_pd(limit);
  std::uint32_t count = 0;
  for (std::uint32_t j = 0; j < kPointsPerBlock; j += 4) {
    const __m256d dx = _mm256_sub_pd(_mm256_loadu_pd(x + j), px4);
    const __m256d dy = _mm256_sub_pd(_mm256_loadu_pd(y + j), py4);
    const __m256d dz = _mm256_sub_pd(_mm256_loadu_pd(z + j), pz4);
    const __m256d squared = _mm256_add_pd(
        _mm256_add_pd(_mm256_mul_pd(dx, dx), _mm256_mul_pd(dy, dy)), _mm256_mul_pd(dz, dz));
    _mm256_storeu_pd(found.squared + j, squared);
    const int mask = _mm256_movemask_pd(_mm256_cmp_pd(squared, limit4, _CMP_LE_OQ));
    const __m128i lanes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kLanes[mask]));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(found.listed + count),
                     _mm_add_epi32(lanes, _mm_set1_epi32(static_cast<int>(j))));
    count += static_cast<std::uint32_t>(__builtin_popcount(static_cast<unsigned>(mask)));
  }
  found.count = count;
}

}  // namespace orbweave
