// The conflict rule: under noise one directed edge can belong to several triangles of T_rho; the
// best stays. docs/dev/ball-pivoting.md.
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "io/triangle_mesh.h"

namespace orbweave {

/// What rivals are judged by.
struct RivalContext {
  std::span<const Vec3> local;    ///< positions relative to the origin, perturbed, by input index
  std::span<const Vec3> normals;  ///< by input index
};

/// How well a triangle's side agrees with its vertex normals: the smallest dot product of its unit
/// normal with their unit normals. The same triangle scores the same bits whichever vertex is its
/// first, and wherever coordinates are counted from.
double agreement(const RivalContext& context, const Triangle& t);

/// Of triangles that share a directed edge, the one that stays: best agreement, then the first by
/// the coordinates of its vertices. Returns its index.
std::size_t best_rival(const RivalContext& context, std::span<const Triangle> rivals);

/// Applies the rule to a sorted set of distinct triangles: a triangle that loses on any edge goes.
/// Returns one flag per triangle, 1 for those that lost.
std::vector<std::uint8_t> find_losers(const RivalContext& context,
                                      std::span<const Triangle> triangles);

}  // namespace orbweave
