// The interpolant of a patch's heights.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "engine/holes/patch/rim.h"
#include "engine/holes/plane/hole_frame.h"
#include "engine/holes/plane/plane_outline.h"
#include "engine/holes/plane/plane_sites.h"
#include "engine/holes/problem/hole.h"
#include "engine/holes/rbf/rbf.h"

namespace orbweave {

/// Fits heights (z) over plane coordinates (x, y) of sites that lie about `spacing` apart. As much
/// smoothing as the heights' own noise calls for (RbfInterpolant::deviance): none on a clean
/// surface, which is interpolated; some tenths of a spacing on a noisy scan.
/// Above options.max_sites: clean sites by greedy choice of centres to options.tolerance, noisy
/// ones by means.
RbfInterpolant fit_heights(const std::vector<Vec3>& places, double spacing,
                           const PatchOptions& options);

/// The heights around a hole, gathered and fitted where one is asked for first: most small holes
/// have no room for a new point, and do without. Safe to ask from many threads.
class HoleHeights {
 public:
  HoleHeights(const HoleProblem& problem, const Rim& rim, const HoleFrame& frame,
              const PlaneOutline& outline, const PatchOptions& options);

  /// Height and gradient at a place of the plane; 0 where there is no interpolant.
  RbfInterpolant::ValueGradient at(Vec3 place) const;

  /// Whether the sheet along the rim is so steep that points over the plane have to be denser.
  bool is_steep() const;

  /// Null until a height was asked for.
  const RbfInterpolant* interpolant() const { return fit_ ? &*fit_ : nullptr; }
  /// Of the interpolant.
  const PlaneSites& sites() const { return sites_; }

 private:
  const HoleProblem& problem_;
  const Rim& rim_;
  const HoleFrame& frame_;
  const PlaneOutline& outline_;
  const PatchOptions& options_;
  mutable std::once_flag once_;
  mutable PlaneSites sites_;
  mutable std::optional<RbfInterpolant> fit_;
};

}  // namespace orbweave
