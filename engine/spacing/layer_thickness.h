// How thick a scanned surface is: noise and misregistration against the spacing of points.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/spacing/automatic_radii.h"

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
LayerThickness measure_layers(std::span<const SpacingSite> sites, const StopToken* stop = nullptr);

/// The cleaning that such layers call for. Every value is 0 where the layers are thin.
struct CleaningChoice {
  double outlier_sigma = 0.0;
  double smooth_radius = 0.0;  ///< world units
  int smooth_passes = 2;
  double thin_to_spacing = 0.0;  ///< world units
  std::string reason;            ///< in words
};
CleaningChoice choose_cleaning(const LayerThickness& layers);

/// "noise 5.3 mm RMS, 17 % of the point spacing (32 mm); above 9 %". `meters_per_unit`: as for
/// readable_length.
std::string short_noise(const LayerThickness& layers, double meters_per_unit = 0.0);
/// The noise, and what the chosen cleaning does about it.
std::string short_reason(const LayerThickness& layers, double meters_per_unit = 0.0);

}  // namespace orbweave
