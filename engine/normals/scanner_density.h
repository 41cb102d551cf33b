// Whether a closed part was seen from its inside, as the density of its points tells: a scanner
// that turns gets points per solid angle, which lie the denser on a surface the nearer it is. Of a
// room seen from its inside all walls tell of the same few places.
#pragma once

#include <span>

#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

/// A patch of the part.
struct DensitySample {
  Vec3 position;
  Vec3 normal;  ///< a unit vector, out of the enclosed volume
  double points = 0.0;
  double area = 0.0;
};

/// Mean squares of relative errors of the density, by area: 0 explains it all, 1 none of it. What
/// scanners leave is without the worst 15 % of the area, where things may stand in the way.
struct DensityFit {
  double even = 0.0;     ///< left by one density everywhere
  double inside = 1.0;   ///< left by the best few scanners inside the bounds; 1: not asked, for
                         ///< the density is even
  double outside = 1.0;  ///< left by as many outside of them

  /// Whether scanners inside explain what nothing else does.
  bool is_seen_from_inside() const;
  /// Whether they explain an uneven density no worse than scanners outside.
  bool may_be_seen_from_inside() const;
};

/// Up to four scanners, one after the other, from the places of a coarse lattice: each the one that
/// explains most of what is left. A scanner lights what faces it; that things stand in the way is
/// not considered. O(samples * places) time and memory, some thousand places. Runs on
/// the calling TBB arena.
DensityFit fit_density(std::span<const DensitySample> samples, const StopToken* stop = nullptr);

}  // namespace orbweave
