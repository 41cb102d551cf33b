// How thick a scanned surface is: noise and misregistration against the spacing of points.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "engine/spacing/searched_sites.h"
#include "engine/spacing/smoothing_levels.h"

namespace orbweave {

struct LayerThickness {
  /// Noise about the local surface: root mean square within a neighbourhood, median over all
  /// places; what detail of the shape contributes is taken off. World units.
  double thickness = 0.0;
  double spacing = 0.0;  ///< median mean distance to the six nearest neighbours
  double radius = 0.0;   ///< of the neighbourhoods that were measured
  std::uint64_t measured = 0;
  /// Share of the places, one in each cube of a lattice, where the layers are thick.
  double thick_share = 0.0;
  double largest_radius = 0.0;  ///< of the smoothing that any of these places asks for; 0: none
  /// Share of the places that lie in two sharp layers beside each other rather than in noise.
  double double_share = 0.0;
  double gap = 0.0;  ///< between those layers, median; world units
  /// Share of the places that have another point closer than a twentieth of the spacing.
  double twin_share = 0.0;
  bool is_thick() const;  ///< too thick for an empty ball to roll over one layer
  /// Thick on the whole or in some part.
  bool is_thick_somewhere() const;
};

/// Measures at a sample of the sites' points, chosen by hash; independent of the points' order. The
/// local surface is a quadric, so that curvature does not count as thickness, in a neighbourhood
/// that grows until it is clearly wider than the layers are thick (docs/cleaning.md). `measured` is
/// 0 where there are too few points. Runs on the calling TBB arena.
LayerThickness measure_layers(const SearchedSites& sites, const StopToken* stop = nullptr);

/// The cleaning that such layers call for. Every value is 0 where the layers are thin.
struct CleaningChoice {
  double outlier_sigma = 0.0;
  /// World units; where the noise of the whole cloud is that of the place.
  double smooth_radius = 0.0;
  int smooth_passes = 2;
  double thin_to_spacing = 0.0;      ///< likewise
  std::uint64_t cluster_points = 0;  ///< small clusters have fewer
  /// What was measured, in words: "noise 0.0072 RMS, 17 % of the point spacing (0.043); above 9 %".
  std::string noise;
};
CleaningChoice choose_cleaning(const LayerThickness& layers);

/// Side of the cubes in which noise is measured place by place.
double noise_cell(const LayerThickness& layers);
/// The radius from which those of places go up and down.
WholeCloudNoise whole_cloud_noise(const LayerThickness& layers);
/// Of the distance between points that thinning keeps, in radii of the smoothing.
inline constexpr double kThinningPerRadius = 0.25;

/// "noise 5.3 mm RMS, 17 % of the point spacing (32 mm); above 9 %". `meters_per_unit`: as for
/// readable_length.
std::string short_noise(const LayerThickness& layers, double meters_per_unit = 0.0);
/// The noise, and what the chosen cleaning does about it.
std::string short_reason(const LayerThickness& layers, double meters_per_unit = 0.0);

}  // namespace orbweave
