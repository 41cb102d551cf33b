// The points of spacing sites: without duplicates, in a fixed order, and which of them to measure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/spacing/spacing_site.h"
#include "io/stop_token.h"

namespace orbweave {

/// Of the coordinates' signs and mantissas: a cloud scaled by a power of two keeps its hashes.
std::uint64_t hash_of(Vec3 p);

/// Which points are measured: those whose hash is at most `last`.
struct PointSelection {
  std::uint64_t last = ~std::uint64_t{0};
  bool takes(Vec3 p) const;
};

/// Of all sites together; a point of two sites counts twice.
std::uint64_t points_of(std::span<const SpacingSite> sites);

/// About `wanted` of the sites' points.
PointSelection select_points(std::span<const SpacingSite> sites, std::uint64_t wanted);

/// Makes copies of a point one; points end in the order of their coordinates. `stop` may be null.
void merge_duplicates(std::span<SpacingSite> sites, const StopToken* stop = nullptr);

/// Makes a site smaller that holds more than `most` points, without copies: halves of the box are
/// left away, by a hash, until what is left holds no more. It is measured as the whole would be, as
/// distances beyond the border of the box do not count. Keeps the order.
void keep_part(SpacingSite& site, std::size_t most, const StopToken* stop = nullptr);

/// Sites without copies of points: those given, or where these have some, others in their place.
class DistinctSites {
 public:
  explicit DistinctSites(std::span<const SpacingSite> sites, const StopToken* stop = nullptr);
  DistinctSites(const DistinctSites&) = delete;
  DistinctSites& operator=(const DistinctSites&) = delete;
  std::span<const SpacingSite> all() const { return sites_; }

 private:
  std::vector<SpacingSite> copies_;
  std::span<const SpacingSite> sites_;
};

/// Distance of a point in the box to the nearest of its faces; infinite for an infinite box.
double distance_to_border(Vec3 p, const Box& box);

/// Four significant digits, whatever the locale.
std::string short_text(double value);
/// Likewise with two digits, for a line on a terminal.
std::string brief_text(double value);

/// A length in a unit that suits it.
struct Length {
  double value = 0.0;
  std::string unit;  ///< " mm", " m", " km" or " ft"; empty where the unit of the scan is not known
};
/// `meters_per_unit`: of the scan; 0: not known. Feet stay feet.
Length readable_length(double value, double meters_per_unit);

}  // namespace orbweave
