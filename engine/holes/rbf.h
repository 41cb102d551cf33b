// Radial basis functions: s(x) = p(x) + sum_i lambda_i phi(|x - x_i|).
// Carr, Beatson, Cherrie, Mitchell, Fright, McCallum, Evans: Reconstruction and Representation of
// 3D Objects with Radial Basis Functions, SIGGRAPH 2001, sections 3 (interpolation) and 5 (greedy
// centre reduction).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/holes/hole.h"

namespace orbweave {

/// A centre of the interpolant. In the plane z is 0.
using RbfSite = Vec3;

struct RbfOptions {
  int dimension = 2;  ///< 2 (z of sites is ignored) or 3
  RbfKernel kernel = RbfKernel::kBiharmonic;
  std::uint32_t max_sites = 1200;  ///< dense up to here (n^3 / 3 operations, 8 n^2 bytes)
  double tolerance = 0.0;          ///< greedy choice ends at this residual, units of the values
};

/// Interpolant of one or several functions given at the same sites.
/// Plane: biharmonic r^2 log r with a linear polynomial, triharmonic r^4 log r with a quadratic
/// one. Space: biharmonic r with a linear polynomial, triharmonic r^3 with a quadratic one.
class RbfInterpolant {
 public:
  /// values: sites.size() rows of `channels`. The order of sites decides ties, nothing else may.
  /// The first channel steers the greedy choice. Sites are centred and scaled inside, so that the
  /// result does not depend on units. valid() is false where the system is singular (all sites on
  /// one line, too few sites, values that are not finite).
  RbfInterpolant(std::span<const RbfSite> sites, std::span<const double> values,
                 std::uint32_t channels, const RbfOptions& options);

  bool valid() const { return valid_; }
  std::uint32_t sites() const { return static_cast<std::uint32_t>(centers_.size()); }
  double residual() const { return residual_; }    ///< largest |s - value| of channel 0
  double condition() const { return condition_; }  ///< estimate of the 1-norm condition number

  /// s at x, one value per channel.
  void evaluate(RbfSite x, std::span<double> out) const;
  double evaluate(RbfSite x) const;  ///< channel 0
  /// Value of channel 0 and its gradient.
  struct ValueGradient {
    double value = 0.0;
    Vec3 gradient;
  };
  ValueGradient evaluate_with_gradient(RbfSite x) const;

 private:
  RbfOptions options_;
  std::uint32_t channels_ = 1;
  Vec3 center_;
  double scale_ = 1.0;
  std::vector<RbfSite> centers_;    ///< scaled
  std::vector<double> weights_;     ///< centers x channels
  std::vector<double> polynomial_;  ///< terms x channels
  double residual_ = 0.0;
  double condition_ = 0.0;
  bool valid_ = false;
};

}  // namespace orbweave
