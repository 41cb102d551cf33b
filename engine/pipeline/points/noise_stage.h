// The noise of raw scans from place to place, and how far cleaning reaches there.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/pipeline/points/raw_passes.h"
#include "engine/spacing/smoothing_levels.h"
#include "io/vec3.h"

namespace orbweave {

/// How far smoothing reaches at each level, and the spacing that thinning keeps there.
struct LocalCleaning {
  std::shared_ptr<const SmoothingLevels> levels = {};  ///< null: all points are at level 1
  std::vector<double> radii = {0.0, 0.0};              ///< ascending; world units
  std::vector<double> spacings = {0.0, 0.0};           ///< likewise; all 0: nothing is thinned

  /// What was measured of the noise, where that was needed; else null.
  std::shared_ptr<const SmoothingLevels> noise = {};

  std::vector<LocalNoise> noise_of(std::span<const Vec3> positions) const;
  std::vector<std::uint8_t> levels_of(std::span<const Vec3> positions) const;
  double largest_radius() const { return radii.back(); }
  /// What decides it beside the points, for keys.
  std::string key() const;
};

/// As the job has it everywhere, or place by place as measured on the raw points; `facts` then
/// tells what that led to, and has no cleaning where hardly any place is thick. Throws
/// RawPointsGone.
LocalCleaning local_cleaning(StageRunner& runner, const RawCloud& cloud, CleaningFacts& facts);

}  // namespace orbweave
