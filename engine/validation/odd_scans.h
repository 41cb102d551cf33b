// Scans that do not lie where the other scans of a job lie, or are not of their size, as files in
// another unit or with another origin of the coordinates are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "io/box.h"
#include "io/vec3.h"

namespace orbweave {

struct PlacedScan {
  Box bounds;                ///< world coordinates
  std::uint64_t points = 0;  ///< in it
  Vec3 origin;               ///< where the scan's own (0, 0, 0) lies
};

enum class OddPlace {
  kApart,    ///< far away from all others
  kLarger,   ///< too large beside all others
  kSmaller,  ///< too small beside all others
};

/// Some scans that are odd in the same way.
struct OddScans {
  OddPlace place = OddPlace::kApart;
  std::vector<std::size_t> scans;  ///< ascending; no more than the others
  double size = 0.0;            ///< diagonal of their bounds; where sizes differ, the nearest one
  double size_of_others = 0.0;  ///< likewise
  double gap = 0.0;             ///< to the others, along the axis where it is widest
  /// The factor between two common units that would bring scans apart to the others; 0: none does.
  double factor = 0.0;
};

/// Scans apart: farther from all others than a hundred times the size of either, ten times where
/// the factor between two common units would bring them together. Else, scans whose sizes differ
/// from those of the others by 300 or more, as do the distances between their points. Scans of
/// fewer than 100 points are passed over. O(n log n), times the number of groups apart.
std::vector<OddScans> odd_scans(std::span<const PlacedScan> scans);

}  // namespace orbweave
