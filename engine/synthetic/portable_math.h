// Arithmetic whose results are the same bits on every machine: +, -, *, /, sqrt and floor only,
// which IEEE 754 fixes (FP contraction is off, see cmake/OrbweaveCompiler.cmake). The C library's
// sin, cos, exp and log may differ in their last bit, so none is used.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "io/vec3.h"

namespace orbweave::portable {

inline constexpr double kPi = 3.14159265358979323846;
/// 2^64 divided by the golden ratio: multiples modulo 2^64 fill the circle evenly.
inline constexpr std::uint64_t kGoldenStep = 0x9E3779B97F4A7C15u;

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

/// Sine and cosine of an angle in turns (1 is a full circle). Error below 3e-16 for |turns| < 1e6
/// beyond that of the argument.
inline SineCosine sine_cosine(double turns) {
  const double quarter = std::floor(4.0 * turns + 0.5);
  const double x = 2.0 * kPi * (turns - 0.25 * quarter);  // within [-pi/4, pi/4]
  const double xx = x * x;
  // Taylor series: the first term left out is below 5e-17.
  double sine = -1.0 / 1307674368000.0;
  for (const double c : {1.0 / 6227020800.0, -1.0 / 39916800.0, 1.0 / 362880.0, -1.0 / 5040.0,
                         1.0 / 120.0, -1.0 / 6.0, 1.0})
    sine = sine * xx + c;
  sine *= x;
  double cosine = 1.0 / 20922789888000.0;
  for (const double c : {-1.0 / 87178291200.0, 1.0 / 479001600.0, -1.0 / 3628800.0, 1.0 / 40320.0,
                         -1.0 / 720.0, 1.0 / 24.0, -0.5, 1.0})
    cosine = cosine * xx + c;
  switch (static_cast<std::int64_t>(quarter) & 3) {
    case 1:
      return {cosine, -sine};
    case 2:
      return {-sine, -cosine};
    case 3:
      return {-cosine, sine};
    default:
      return {sine, cosine};
  }
}

/// Cube root of a value in [1, 64].
inline double cube_root(double value) {
  double root = 1.0 + (value - 1.0) * (3.0 / 63.0);  // the chord: at most 0.8 below the root
  for (int step = 0; step < 6; ++step) root = (2.0 * root + value / (root * root)) / 3.0;
  return root;
}

/// splitmix64's finaliser (Steele, Lea, Flood 2014): a bijection that scatters neighbours.
inline std::uint64_t mixed(std::uint64_t word) {
  word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9u;
  word = (word ^ (word >> 27)) * 0x94D049BB133111EBu;
  return word ^ (word >> 31);
}

/// 53 random bits as a fraction in [0, 1).
inline double fraction(std::uint64_t word) { return static_cast<double>(word >> 11) * 0x1p-53; }

/// Not inlined: where GCC 12 vectorises the way to float and back, it drops the rounding.
[[gnu::noinline]] inline double rounded_to_float(double value) {
  return static_cast<double>(static_cast<float>(value));
}
inline Vec3 rounded_to_float(Vec3 v) {
  return {rounded_to_float(v.x), rounded_to_float(v.y), rounded_to_float(v.z)};
}

/// Three independent, nearly Gaussian numbers of mean 0 and standard deviation 1: each the sum of
/// 12 uniforms (Irwin-Hall; kurtosis 2.9 instead of 3, never beyond 6). A pure function of
/// (seed, index).
inline Vec3 gaussian(std::uint64_t seed, std::uint64_t index) {
  const std::uint64_t start = mixed(seed + kGoldenStep) + 12 * index * kGoldenStep;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 21) - 1;
  std::array<std::uint64_t, 3> sums{};
  for (std::uint64_t draw = 1; draw <= 12; ++draw) {
    const std::uint64_t word = mixed(start + draw * kGoldenStep);
    sums[0] += word & kMask;
    sums[1] += (word >> 21) & kMask;
    sums[2] += (word >> 42) & kMask;
  }
  // Each uniform is the middle of its 2^-21 cell: 12 halves make the 6.
  const auto centred = [](std::uint64_t sum) {
    return (static_cast<double>(sum) + 6.0) * 0x1p-21 - 6.0;
  };
  return {centred(sums[0]), centred(sums[1]), centred(sums[2])};
}

}  // namespace orbweave::portable
