// Kernels and polynomials of the radial basis functions, as arithmetic that is the same on every
// machine: no library logarithm, whose last bit depends on the processor.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "engine/holes/problem/hole.h"
#include "engine/holes/rbf/rbf_loops.h"

namespace orbweave {

/// The natural logarithm of a positive normal number, to about two units in the last place: with
/// x = 2^k m and s = (m - 1) / (m + 1), log x = k log 2 + 2 artanh s, |s| < 0.172. Branch-free
/// and without conversions, so that rbf_loops.inl computes the same bits on several lanes.
inline double rbf_log(double x) {
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcd;  // sqrt(1/2): m lies in [it, 2 x it)
  constexpr std::uint64_t kOne = 0x3ff0000000000000;
  constexpr std::uint64_t kTwo52 = 0x4330000000000000;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x) + (kOne - kRootHalf);
  const std::uint64_t exponent = bits >> 52;
  const double k = std::bit_cast<double>(exponent | kTwo52) - (0x1p52 + 1023.0);
  const double m = std::bit_cast<double>((bits & 0x000fffffffffffff) + kRootHalf);
  const double s = (m - 1.0) / (m + 1.0);
  const double t = s * s;
  // Without a loop, which would keep loops around it from being vectorised.
  double series = 1.0 / 19.0 + t * (1.0 / 21.0);
  series = 1.0 / 15.0 + t * (1.0 / 17.0 + t * series);
  series = 1.0 / 11.0 + t * (1.0 / 13.0 + t * series);
  series = 1.0 / 7.0 + t * (1.0 / 9.0 + t * series);
  series = 1.0 / 3.0 + t * (1.0 / 5.0 + t * series);
  return k * 0x1.62e42fefa39efp-1 + 2.0 * (s + s * (t * series));
}

RbfForm rbf_form(int dimension, RbfKernel kernel);

/// Smoothing: what is added to the kernel matrix's diagonal so that details shorter than about
/// 2 pi x `length` fade where sites lie `spacing` apart.
double rbf_ridge(RbfForm form, double length, double spacing);

/// The most terms of a polynomial: quadratic in space.
inline constexpr int kRbfTerms = 10;
int rbf_terms(RbfForm form);
/// Monomials at x: 1, x, y[, z][, squares and products].
std::array<double, kRbfTerms> rbf_monomials(RbfForm form, Vec3 x);
/// Their derivatives along x, y and z.
std::array<Vec3, kRbfTerms> rbf_monomial_gradients(RbfForm form, Vec3 x);

}  // namespace orbweave
