// General position: every point is decided about as if it were moved by a tiny pseudo-random
// vector derived from the bits of its coordinates. The output keeps the original coordinates.
#pragma once

#include <bit>
#include <cstdint>

#include "io/vec3.h"

namespace orbweave {

/// Fraction of the smallest ball radius by which points are moved along each axis, at most (where
/// the radii differ by less than a factor of some thousands; docs/dev/halo.md).
inline constexpr double kPerturbation = 1e-6;

/// A finaliser of good avalanche (Stafford's variant 13 of MurmurHash3's mix, 2011).
constexpr std::uint64_t mix_bits(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Hash of a position; -0 counts as 0.
constexpr std::uint64_t position_hash(Vec3 p) {
  std::uint64_t hash = mix_bits(std::bit_cast<std::uint64_t>(p.x + 0.0) + 0x9e3779b97f4a7c15u);
  hash = mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.y + 0.0));
  return mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.z + 0.0));
}

/// Vector with components in [-scale, scale), a pure function of the coordinates' bits.
constexpr Vec3 perturbation(Vec3 p, double scale) {
  const std::uint64_t hash = position_hash(p);
  const auto component = [scale](std::uint64_t bits) {
    return scale * (static_cast<double>(bits & 0x1fffff) * 0x1p-20 - 1.0);
  };
  return {component(hash), component(hash >> 21), component(hash >> 42)};
}

}  // namespace orbweave
