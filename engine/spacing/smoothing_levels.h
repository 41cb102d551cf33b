// How far smoothing reaches from place to place: it follows the noise where that is.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry/neighbor_grid.h"
#include "engine/spacing/noise_places.h"
#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

/// What holds for the whole cloud: the steps of the radius go up and down from it.
struct WholeCloudNoise {
  double radius = 0.0;    ///< that its noise and spacing ask for; world units, positive
  bool is_thick = false;  ///< places without a surface are smoothed with it
  double most = 0.0;      ///< no radius is larger than the step that is nearest to it; 0: no limit
};

/// The radius that noise and spacing ask for; 0 where the layers are thin enough.
double wanted_radius(double spacing, double noise);

/// Noise and spacing in a cube and those around it; -1: not known.
struct LocalNoise {
  float spacing = -1.0F;
  float noise = -1.0F;
};

/// The level of every place: 0 where nothing is to be moved, else that of the radius, which is a
/// power of two times that of the whole cloud. The noise of a cube is the median over the places in
/// the 125 cubes around it, so that levels change slowly.
class SmoothingLevels {
 public:
  SmoothingLevels() = default;
  /// Places in any order; the result does not depend on it. Runs on the calling TBB arena.
  SmoothingLevels(std::vector<NoisePlace> places, double cell, const WholeCloudNoise& whole,
                  const StopToken* stop = nullptr);

  /// Of the levels, ascending; the first is 0. No more than one: nothing is to be moved.
  std::span<const double> radii() const { return radii_; }
  /// Share of the occupied cubes at level 0.
  double untouched_share() const;

  std::vector<std::uint8_t> at(std::span<const Vec3> positions) const;
  std::vector<LocalNoise> noise_at(std::span<const Vec3> positions) const;

 private:
  struct Cube {
    LatticeCell cell;
    LocalNoise noise;
    std::uint8_t level = 0;
  };
  struct Scratch {
    std::vector<double> spacings, noises;
  };

  void sort_by_cubes(std::vector<NoisePlace> places);
  /// The noise of a cube; returns its radius.
  double measure(const LatticeCell& cell, Scratch& scratch, Cube& cube) const;
  double step_of(double wanted) const;
  std::uint8_t level_of(double radius) const;
  Cube cube_at(const LatticeCell& cell, Scratch& scratch) const;
  void number_levels(const std::vector<double>& radius_of_cube);
  template <class Visit>
  void visit_cubes(std::span<const Vec3> positions, const Visit& visit) const;

  double cell_ = 1.0;
  WholeCloudNoise whole_;
  std::vector<double> radii_ = {0.0};
  std::vector<LatticeCell> cell_of_place_;  ///< ascending
  std::vector<NoisePlace> places_;          ///< in that order
  std::vector<Cube> cubes_;                 ///< occupied ones, ascending
};

}  // namespace orbweave
