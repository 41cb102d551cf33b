// The few vector operations of the walk and of searches for neighbours, for three widths. A
// translation unit that defines ORBWEAVE_SIMD_AVX512 or ORBWEAVE_SIMD_AVX2 (and is compiled for it)
// gets that one, every other the scalar form. All forms compute the same bits per lane: additions
// and multiplications are never fused, square root and division are correctly rounded everywhere.
#pragma once

#if defined(ORBWEAVE_SIMD_AVX512) || defined(ORBWEAVE_SIMD_AVX2)
#include <immintrin.h>
#endif
#if defined(ORBWEAVE_SIMD_AVX2)
#include "engine/geometry/packed_lanes.h"
#endif

#include <cmath>
#include <cstdint>

namespace orbweave {
namespace {  // every including unit is compiled for another machine: nothing may be shared

#if defined(ORBWEAVE_SIMD_AVX512)

struct Lanes {
  static constexpr std::uint32_t kWidth = 8;
  using Mask = __mmask8;
  __m512d v;
  static Lanes load(const double* p) { return {_mm512_loadu_pd(p)}; }
  static Lanes all(double x) { return {_mm512_set1_pd(x)}; }
  static Lanes counting_from(double x) {
    return {_mm512_add_pd(_mm512_set1_pd(x), _mm512_setr_pd(0, 1, 2, 3, 4, 5, 6, 7))};
  }
  void store(double* p) const { _mm512_storeu_pd(p, v); }
  friend Lanes operator+(Lanes a, Lanes b) { return {_mm512_add_pd(a.v, b.v)}; }
  friend Lanes operator-(Lanes a, Lanes b) { return {_mm512_sub_pd(a.v, b.v)}; }
  friend Lanes operator*(Lanes a, Lanes b) { return {_mm512_mul_pd(a.v, b.v)}; }
  friend Lanes operator/(Lanes a, Lanes b) { return {_mm512_div_pd(a.v, b.v)}; }
  friend Mask operator<(Lanes a, Lanes b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_LT_OQ); }
  friend Mask operator<=(Lanes a, Lanes b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_LE_OQ); }
  friend Mask operator==(Lanes a, Lanes b) { return _mm512_cmp_pd_mask(a.v, b.v, _CMP_EQ_OQ); }
};
inline Lanes square_root(Lanes a) { return {_mm512_sqrt_pd(a.v)}; }
inline Lanes larger(Lanes a, Lanes b) { return {_mm512_max_pd(a.v, b.v)}; }
inline Lanes smaller(Lanes a, Lanes b) { return {_mm512_min_pd(a.v, b.v)}; }
inline Lanes choose(Lanes::Mask m, Lanes yes, Lanes no) {
  return {_mm512_mask_blend_pd(m, no.v, yes.v)};
}
inline double smallest(Lanes a) { return _mm512_reduce_min_pd(a.v); }
inline double largest(Lanes a) { return _mm512_reduce_max_pd(a.v); }
/// The smallest lane of the (non-empty) mask.
inline double smallest_of(Lanes a, Lanes::Mask m) {
  if ((m & (m - 1)) == 0) return _mm512_cvtsd_f64(_mm512_maskz_compress_pd(m, a.v));
  return _mm512_mask_reduce_min_pd(m, a.v);
}
inline Lanes::Mask both(Lanes::Mask a, Lanes::Mask b) { return a & b; }
inline Lanes::Mask either(Lanes::Mask a, Lanes::Mask b) { return a | b; }
inline Lanes::Mask but_not(Lanes::Mask a, Lanes::Mask b) {
  return static_cast<Lanes::Mask>(a & ~b);
}
inline bool any(Lanes::Mask m) { return m != 0; }
inline unsigned bits_of(Lanes::Mask m) { return m; }
inline std::uint32_t count(Lanes::Mask m) {
  return static_cast<std::uint32_t>(__builtin_popcount(m));
}
/// Stores the lanes of the mask side by side; writes up to a full vector behind `p`.
inline void compress_store(double* p, Lanes a, Lanes::Mask m) {
  _mm512_storeu_pd(p, _mm512_maskz_compress_pd(m, a.v));
}
/// Stores first + lane for the lanes of the mask.
inline void compress_store_indices(std::uint32_t* p, std::uint32_t first, Lanes::Mask m) {
  const __m256i index = _mm256_add_epi32(_mm256_set1_epi32(static_cast<int>(first)),
                                         _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm256_maskz_compress_epi32(m, index));
}
/// Stores the numbers of a full vector that are in lanes of the mask side by side.
inline void compress_store_numbers(std::uint32_t* p, const std::uint32_t* numbers, Lanes::Mask m) {
  const __m256i all = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(numbers));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm256_maskz_compress_epi32(m, all));
}
inline Lanes::Mask first_lanes(std::uint32_t n) {
  return static_cast<Lanes::Mask>(n >= 8 ? 0xff : (1u << n) - 1u);
}
inline Lanes::Mask lane_mask(std::uint32_t lane) { return static_cast<Lanes::Mask>(1u << lane); }

#elif defined(ORBWEAVE_SIMD_AVX2)

struct Lanes {
  static constexpr std::uint32_t kWidth = 4;
  struct Mask {
    __m256d v;
  };
  __m256d v;
  static Lanes load(const double* p) { return {_mm256_loadu_pd(p)}; }
  static Lanes all(double x) { return {_mm256_set1_pd(x)}; }
  static Lanes counting_from(double x) {
    return {_mm256_add_pd(_mm256_set1_pd(x), _mm256_setr_pd(0, 1, 2, 3))};
  }
  void store(double* p) const { _mm256_storeu_pd(p, v); }
  friend Lanes operator+(Lanes a, Lanes b) { return {_mm256_add_pd(a.v, b.v)}; }
  friend Lanes operator-(Lanes a, Lanes b) { return {_mm256_sub_pd(a.v, b.v)}; }
  friend Lanes operator*(Lanes a, Lanes b) { return {_mm256_mul_pd(a.v, b.v)}; }
  friend Lanes operator/(Lanes a, Lanes b) { return {_mm256_div_pd(a.v, b.v)}; }
  friend Mask operator<(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LT_OQ)}; }
  friend Mask operator<=(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_LE_OQ)}; }
  friend Mask operator==(Lanes a, Lanes b) { return {_mm256_cmp_pd(a.v, b.v, _CMP_EQ_OQ)}; }
};
inline Lanes square_root(Lanes a) { return {_mm256_sqrt_pd(a.v)}; }
inline Lanes larger(Lanes a, Lanes b) { return {_mm256_max_pd(a.v, b.v)}; }
inline Lanes smaller(Lanes a, Lanes b) { return {_mm256_min_pd(a.v, b.v)}; }
inline Lanes choose(Lanes::Mask m, Lanes yes, Lanes no) {
  return {_mm256_blendv_pd(no.v, yes.v, m.v)};
}
inline double smallest(Lanes a) {
  const __m128d half = _mm_min_pd(_mm256_castpd256_pd128(a.v), _mm256_extractf128_pd(a.v, 1));
  return _mm_cvtsd_f64(_mm_min_sd(half, _mm_unpackhi_pd(half, half)));
}
inline double largest(Lanes a) {
  const __m128d half = _mm_max_pd(_mm256_castpd256_pd128(a.v), _mm256_extractf128_pd(a.v, 1));
  return _mm_cvtsd_f64(_mm_max_sd(half, _mm_unpackhi_pd(half, half)));
}
inline double smallest_of(Lanes a, Lanes::Mask m) {
  return smallest(choose(m, a, Lanes::all(1e300)));
}
inline Lanes::Mask both(Lanes::Mask a, Lanes::Mask b) { return {_mm256_and_pd(a.v, b.v)}; }
inline Lanes::Mask either(Lanes::Mask a, Lanes::Mask b) { return {_mm256_or_pd(a.v, b.v)}; }
inline Lanes::Mask but_not(Lanes::Mask a, Lanes::Mask b) { return {_mm256_andnot_pd(b.v, a.v)}; }
inline unsigned bits_of(Lanes::Mask m) { return static_cast<unsigned>(_mm256_movemask_pd(m.v)); }
inline bool any(Lanes::Mask m) { return bits_of(m) != 0; }
inline std::uint32_t count(Lanes::Mask m) {
  return static_cast<std::uint32_t>(__builtin_popcount(bits_of(m)));
}
/// Stores the lanes of the mask side by side; writes up to a full vector behind `p`.
inline void compress_store(double* p, Lanes a, Lanes::Mask m) {
  const __m256i order = _mm256_load_si256(
      reinterpret_cast<const __m256i*>(kPackedLanes.halves[_mm256_movemask_pd(m.v)]));
  const __m256i packed = _mm256_permutevar8x32_epi32(_mm256_castpd_si256(a.v), order);
  _mm256_storeu_pd(p, _mm256_castsi256_pd(packed));
}
/// Stores first + lane for the lanes of the mask; writes up to a full vector behind `p`.
inline void compress_store_indices(std::uint32_t* p, std::uint32_t first, Lanes::Mask m) {
  const __m128i lanes =
      _mm_load_si128(reinterpret_cast<const __m128i*>(kPackedLanes.lanes[_mm256_movemask_pd(m.v)]));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p),
                   _mm_add_epi32(_mm_set1_epi32(static_cast<int>(first)), lanes));
}
/// Stores the numbers of a full vector that are in lanes of the mask side by side.
inline void compress_store_numbers(std::uint32_t* p, const std::uint32_t* numbers, Lanes::Mask m) {
  const __m128i order =
      _mm_load_si128(reinterpret_cast<const __m128i*>(kPackedLanes.lanes[_mm256_movemask_pd(m.v)]));
  const __m128 all = _mm_castsi128_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(numbers)));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm_castps_si128(_mm_permutevar_ps(all, order)));
}
inline Lanes::Mask first_lanes(std::uint32_t n) {
  return Lanes::counting_from(0.0) < Lanes::all(static_cast<double>(n));
}
inline Lanes::Mask lane_mask(std::uint32_t lane) {
  return Lanes::counting_from(0.0) == Lanes::all(static_cast<double>(lane));
}

#else

struct Lanes {
  static constexpr std::uint32_t kWidth = 1;
  using Mask = bool;
  double v;
  static Lanes load(const double* p) { return {*p}; }
  static Lanes all(double x) { return {x}; }
  static Lanes counting_from(double x) { return {x}; }
  void store(double* p) const { *p = v; }
  friend Lanes operator+(Lanes a, Lanes b) { return {a.v + b.v}; }
  friend Lanes operator-(Lanes a, Lanes b) { return {a.v - b.v}; }
  friend Lanes operator*(Lanes a, Lanes b) { return {a.v * b.v}; }
  friend Lanes operator/(Lanes a, Lanes b) { return {a.v / b.v}; }
  friend Mask operator<(Lanes a, Lanes b) { return a.v < b.v; }
  friend Mask operator<=(Lanes a, Lanes b) { return a.v <= b.v; }
  friend Mask operator==(Lanes a, Lanes b) { return a.v == b.v; }
};
inline Lanes square_root(Lanes a) { return {std::sqrt(a.v)}; }
inline Lanes larger(Lanes a, Lanes b) { return {a.v > b.v ? a.v : b.v}; }
inline Lanes smaller(Lanes a, Lanes b) { return {a.v < b.v ? a.v : b.v}; }
inline Lanes choose(Lanes::Mask m, Lanes yes, Lanes no) { return m ? yes : no; }
inline double smallest(Lanes a) { return a.v; }
inline double largest(Lanes a) { return a.v; }
inline double smallest_of(Lanes a, Lanes::Mask) { return a.v; }
inline Lanes::Mask both(Lanes::Mask a, Lanes::Mask b) { return a && b; }
inline Lanes::Mask either(Lanes::Mask a, Lanes::Mask b) { return a || b; }
inline Lanes::Mask but_not(Lanes::Mask a, Lanes::Mask b) { return a && !b; }
inline bool any(Lanes::Mask m) { return m; }
inline unsigned bits_of(Lanes::Mask m) { return m ? 1u : 0u; }
inline std::uint32_t count(Lanes::Mask m) { return m ? 1 : 0; }
inline void compress_store(double* p, Lanes a, Lanes::Mask m) {
  if (m) *p = a.v;
}
inline void compress_store_indices(std::uint32_t* p, std::uint32_t first, Lanes::Mask m) {
  if (m) *p = first;
}
inline void compress_store_numbers(std::uint32_t* p, const std::uint32_t* numbers, Lanes::Mask m) {
  if (m) *p = *numbers;
}
inline Lanes::Mask first_lanes(std::uint32_t n) { return n > 0; }
inline Lanes::Mask lane_mask(std::uint32_t) { return true; }

#endif

}  // namespace
}  // namespace orbweave
