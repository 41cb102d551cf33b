// How thick a scanned surface is: noise and misregistration against the spacing of points.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/ball_pivoting/automatic_radii.h"
#include "io/job.h"

namespace orbweave {

struct LayerThickness {
  /// Noise about the local surface: root mean square within a neighbourhood, median over all
  /// places; what detail of the shape contributes is taken off. World units.
  double thickness = 0.0;
  double spacing = 0.0;  ///< median mean distance to the six nearest neighbours
  double radius = 0.0;   ///< of the neighbourhoods that were measured
  std::uint64_t measured = 0;
  bool is_thick() const;  ///< too thick for an empty ball to roll over one layer
};

/// Measures at a sample of the sites' points, chosen by hash; independent of the points' order. The
/// local surface is a quadric, so that curvature does not count as thickness, in a neighbourhood
/// that grows until it is clearly wider than the layers are thick (docs/cleaning.md). `measured` is
/// 0 where there are too few points. Runs on the calling TBB arena.
LayerThickness measure_layers(std::span<const SpacingSite> sites);

/// What the clean-up should be for such layers, and why, in words: outliers, smoothing radius and
/// spacing. Nothing is on where the layers are thin.
struct PrepareChoice {
  PrepareOptions options;
  std::string reason;
};
PrepareChoice choose_preparation(const LayerThickness& layers);

}  // namespace orbweave
