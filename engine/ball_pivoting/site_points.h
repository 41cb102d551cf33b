// The points of spacing sites: without duplicates, in a fixed order, and which of them to measure.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/automatic_radii.h"

namespace orbweave {

/// Which points are measured: those whose hash is at most `last`. Only signs and mantissas are
/// hashed, so a cloud scaled by a power of two is measured at the same points.
struct PointSelection {
  std::uint64_t last = ~std::uint64_t{0};
  bool takes(Vec3 p) const;
};

/// About `wanted` of the sites' points.
PointSelection select_points(std::span<const SpacingSite> sites, std::uint64_t wanted);

/// The sites with their points sorted, so that sums do not depend on how points came, and without
/// duplicates. Runs on the calling TBB arena.
std::vector<SpacingSite> distinct_sites(std::span<const SpacingSite> sites);

/// Distance of a point in the box to the nearest of its faces; infinite for an infinite box.
double distance_to_border(Vec3 p, const Box& box);

/// Four significant digits, whatever the locale.
std::string short_text(double value);

}  // namespace orbweave
