// What a point cloud is like: what `inspect` says of a scan.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/validation/attribute_facts.h"
#include "io/box.h"
#include "io/points/point_source.h"

namespace orbweave {

struct CloudFacts {
  std::uint64_t points = 0;
  Box bounds;  ///< of the finite points
  bool has_normals = false;
  ScalarType position_type = ScalarType::kFloat64;
  std::vector<AttributeField> attributes;
  AttributeFacts values;          ///< of the attributes
  FileFacts file;                 ///< what the file says of itself
  DroppedPoints left_out;         ///< what the reader or a selection left out, by reason
  std::string coordinate_system;  ///< WKT or a code; empty: unknown
  std::optional<Vec3> meters_per_unit;
  std::uint64_t not_finite = 0;             ///< points with a NaN or infinite coordinate
  std::uint64_t zero_normals = 0;           ///< points whose normal is zero
  std::uint64_t normals_not_finite = 0;     ///< points whose normal has a NaN or infinite component
  std::optional<std::uint64_t> duplicates;  ///< finite points equal to an earlier one
  /// Median distance to the nearest neighbour, and median of the mean distance to the six nearest;
  /// exact duplicates are one point. None where no two points differ.
  std::optional<double> spacing;
  std::optional<double> spacing_of_six;
  double coordinate_step = 0.0;  ///< last place of floats that coordinates were rounded to; 0: none
  double common_step = 0.0;      ///< what coordinates of all axes are multiples of; 0: nothing
  std::string doubt;             ///< what is wrong with coordinates; empty: nothing
};

struct CloudFactsOptions {
  /// Clouds of at most this number of points are kept whole while their spacing is measured.
  std::uint64_t whole_spacing_points = 2'000'000;
  /// Duplicates are counted in clouds of at most this number of points (8 bytes each), by 64-bit
  /// hashes of coordinates.
  std::uint64_t duplicate_points = 20'000'000;
};

/// Reads the source to its end, in bounded memory (at most about 300 MB). Up to
/// whole_spacing_points points, neighbours are searched in the whole cloud. For larger clouds they
/// are searched in small cubes from all over it (engine/spacing/automatic_radii.h), for which
/// the cloud is read a second time from `again`; without it they have no spacing. Distances are
/// measured at up to 32,768 points chosen by hash; facts do not depend on the order of points.
CloudFacts cloud_facts(PointSource& source, PointSource* again = nullptr,
                       const CloudFactsOptions& options = {});

}  // namespace orbweave
