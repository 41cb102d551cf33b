// Choosing centres for radial basis functions among given sites.
// Carr et al., SIGGRAPH 2001, section 5.1.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/vec3.h"

namespace orbweave {

/// Sites without their duplicates, in the order of their first appearance.
struct UniqueSites {
  std::vector<Vec3> sites;
  std::vector<std::uint32_t> of;    ///< unique site of each given one
  std::vector<std::uint8_t> exact;  ///< not to be smoothed
  std::uint32_t channels = 1;
  std::vector<double> values;  ///< unique sites x channels, means over the duplicates
};
UniqueSites merge_duplicates(const std::vector<Vec3>& sites, std::span<const double> values,
                             std::uint32_t channels, std::uint32_t exact_sites);

/// Sites far from each other: each is the one furthest from the seeds and from those before.
class FarthestPoints {
 public:
  FarthestPoints(const std::vector<Vec3>& sites, std::span<const std::uint32_t> seeds);
  /// The next one; empty where none is left. O(n).
  std::optional<std::uint32_t> next();
  /// The largest distance of a site from the nearest one chosen.
  double radius() const;

 private:
  void cover(std::uint32_t center);

  const std::vector<Vec3>& sites_;
  std::vector<double> squared_;  ///< from the nearest one chosen
};

/// At most `count` of the candidates, the worst ones first, at least `separation` apart; filled
/// up to half of `count` with the next worst if these are fewer.
std::vector<std::uint32_t> worst_sites(const std::vector<Vec3>& sites,
                                       const std::vector<double>& residuals,
                                       std::vector<std::uint32_t> candidates, std::size_t count,
                                       double separation);

}  // namespace orbweave
