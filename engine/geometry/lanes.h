// Four doubles at once, for units that are compiled once per vector width. Every width computes the
// same bits: no operation is fused, and sums over lanes are added in a fixed order.
#pragma once

#if defined(__AVX2__)
#include <immintrin.h>

#include "engine/geometry/packed_lanes.h"
#endif

#include <cstdint>

namespace orbweave {
namespace {  // every including unit is compiled for another machine: nothing may be shared

using Four = double __attribute__((vector_size(32)));
using FourMask = long long __attribute__((vector_size(32)));

inline Four load(const double* from) {
  Four v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
inline void store(double* to, Four v) { __builtin_memcpy(to, &v, sizeof v); }
inline Four all(double x) { return Four{x, x, x, x}; }
inline double sum_of(Four v) { return (v[0] + v[1]) + (v[2] + v[3]); }
inline Four choose(FourMask mask, Four yes, Four no) {
  return reinterpret_cast<Four>((mask & reinterpret_cast<FourMask>(yes)) |
                                (~mask & reinterpret_cast<FourMask>(no)));
}
/// Where the mask does not hold: zero.
inline Four only(FourMask mask, Four v) {
  return reinterpret_cast<Four>(mask & reinterpret_cast<FourMask>(v));
}
inline Four absolute(Four v) {
  const long long magnitude = 0x7fffffffffffffff;
  const FourMask mask{magnitude, magnitude, magnitude, magnitude};
  return only(mask, v);
}
inline Four larger(Four a, Four b) { return choose(a > b, a, b); }

#if defined(__AVX2__)

inline unsigned bits_of(FourMask mask) {
  return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
}
inline Four square_root(Four v) { return _mm256_sqrt_pd(v); }

/// Stores lanes of a mask side by side; writes up to four values.
class Packing {
 public:
  explicit Packing(unsigned bits) : bits_(bits) {}
  void store(double* to, Four v) const {
    const auto order =
        _mm256_load_si256(reinterpret_cast<const __m256i*>(kPackedLanes.halves[bits_]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                        _mm256_permutevar8x32_epi32(_mm256_castpd_si256(v), order));
  }

 private:
  unsigned bits_;
};

#else

inline unsigned bits_of(FourMask mask) {
  return static_cast<unsigned>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
}
inline Four square_root(Four v) {
  return Four{__builtin_sqrt(v[0]), __builtin_sqrt(v[1]), __builtin_sqrt(v[2]),
              __builtin_sqrt(v[3])};
}

/// Stores lanes of a mask side by side; writes up to four values.
class Packing {
 public:
  explicit Packing(unsigned bits) : bits_(bits) {}
  void store(double* to, Four v) const {
    for (int lane = 0; lane < 4; ++lane) {
      *to = v[lane];
      to += bits_ >> lane & 1;
    }
  }

 private:
  unsigned bits_;
};

#endif

inline std::uint32_t count_of(unsigned bits) {
  return static_cast<std::uint32_t>(__builtin_popcount(bits));
}

}  // namespace
}  // namespace orbweave
