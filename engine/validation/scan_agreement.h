// Whether scans that overlap lie on one surface, at a sample of the sites where distances are
// measured: around a point of one scan, the local plane of its own points against that of the
// points of another scan. A scan whose pose is wrong meets the others at angles, or beside them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/spacing/spacing_site.h"
#include "io/points/point_source.h"
#include "io/stop_token.h"

namespace orbweave {

/// A scan that does not lie on the surface of the others.
struct OffScan {
  std::size_t scan = 0;
  std::uint64_t meetings = 0;  ///< places where the scan meets another one, once for each of these
  std::uint64_t off = 0;       ///< of them, where the two are different surfaces
  double distance = 0.0;       ///< between the two where they meet, median; world units
  double spacings = 0.0;       ///< the same, in spacings of the sparser scan there
  std::size_t beside = 0;      ///< the scan that it most often is off
};

/// Looks at some thousand points, chosen by a hash of their coordinates. `scan_of_point`: of each
/// point of each site, below `scanners.size()`; `scanners`: where each scan was seen from, where
/// that is known. Surfaces that face away from each other, as the two sides of a wall do, are not
/// compared; where that is not known, parallel ones are not. Scans are found one by one, the worst
/// first, each compared with those that are left. Does not depend on the order of the points.
/// Runs on the calling TBB arena.
std::vector<OffScan> scans_off_surface(std::span<const SpacingSite> sites,
                                       std::span<const std::vector<std::uint32_t>> scan_of_point,
                                       std::span<const std::optional<ScannerPlace>> scanners,
                                       const StopToken* stop = nullptr);

}  // namespace orbweave
