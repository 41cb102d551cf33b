// Radial basis functions: s(x) = p(x) + sum_i lambda_i phi(|x - x_i|).
// Carr, Beatson, Cherrie, Mitchell, Fright, McCallum, Evans: Reconstruction and Representation of
// 3D Objects with Radial Basis Functions, SIGGRAPH 2001, sections 3 (interpolation) and 5 (greedy
// centre reduction).
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "engine/holes/problem/hole.h"
#include "engine/holes/rbf/rbf_loops.h"

namespace orbweave {

/// A centre of the interpolant. In the plane z is 0.
using RbfSite = Vec3;

struct RbfOptions {
  int dimension = 2;  ///< 2 (z of sites is ignored) or 3
  RbfKernel kernel = RbfKernel::kBiharmonic;
  std::uint32_t max_sites = 1200;  ///< dense up to here (n^3 / 3 operations, 8 n^2 bytes)
  double tolerance = 0.0;          ///< greedy choice ends at this residual, units of the values
  /// Details of the values shorter than about 2 pi times this length are smoothed, world units;
  /// 0: interpolation. Where `dimension` is 3 it is a mere strength.
  double smoothing_length = 0.0;
  double site_spacing = 0.0;  ///< mean distance of neighbours; used with smoothing only
  std::uint32_t exact_sites =
      0;                ///< number of sites, the first ones, that are interpolated exactly
  bool measure = true;  ///< whether residual() is wanted
};

/// Interpolant of one or several functions given at the same sites.
/// Plane: biharmonic r^2 log r with a linear polynomial, triharmonic r^4 log r with a quadratic
/// one. Space: biharmonic r with a linear polynomial, triharmonic r^3 with a quadratic one.
/// Safe to evaluate from several threads.
class RbfInterpolant {
 public:
  class Family;

  /// values: sites.size() rows of `channels`. The order of sites decides ties, nothing else may.
  /// The first channel steers the greedy choice. Sites are centred and scaled inside, so that the
  /// result does not depend on units. Sites at the same place count as one with their mean value.
  /// valid() is false where the system is singular (all sites on one line, too few sites, sites
  /// much closer than the rest, values that are not finite).
  RbfInterpolant(std::span<const RbfSite> sites, std::span<const double> values,
                 std::uint32_t channels, const RbfOptions& options);

  bool valid() const { return valid_; }
  /// Centres used.
  std::uint32_t sites() const { return static_cast<std::uint32_t>(centers_[0].size()); }
  /// Largest |s - value| of channel 0, all sites; 0 without options.measure.
  double residual() const { return residual_; }
  /// Estimate of the 1-norm condition number of the system that is left when the polynomial has
  /// been eliminated.
  double condition() const { return condition_; }
  /// How badly the values of channel 0 agree with the kernel and its smoothing, up to a constant:
  /// of several amounts of smoothing, that of the least deviance suits the noise in the values.
  /// Only for comparing fits to the same sites.
  /// Wahba: A Comparison of GCV and GML for Choosing the Smoothing Parameter in the Generalized
  /// Spline Smoothing Problem, Annals of Statistics 1985.
  double deviance() const { return deviance_; }

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
  class Fit;
  RbfInterpolant(std::uint32_t channels, const RbfOptions& options)
      : options_(options), channels_(channels) {}
  bool set_frame(std::span<const RbfSite> sites);
  RbfSite scaled(RbfSite x) const;
  void take(const Fit& fit);
  bool use_all(Fit& fit, double deviance_limit);
  bool choose_greedily(Fit& fit, std::uint32_t cap);
  std::vector<double> residuals_at(const Fit& fit) const;
  std::vector<double> values_at(const std::vector<Vec3>& in_frame) const;
  RbfColumns block_of_centers(std::size_t first) const;
  void evaluate_scaled(RbfSite x, std::span<double> out) const;

  RbfOptions options_;
  std::uint32_t channels_ = 1;
  Vec3 center_;
  double scale_ = 1.0;
  std::array<std::vector<double>, 3> centers_;  ///< x, y, z; scaled
  std::vector<double> weights_;                 ///< channels x centers
  std::vector<double> polynomial_;              ///< channels x terms
  double residual_ = 0.0;
  double condition_ = 0.0;
  double deviance_ = 0.0;
  bool valid_ = false;
};

/// Interpolants of the same values at the same sites, each with another smoothing length: what does
/// not depend on it is computed once.
class RbfInterpolant::Family {
 public:
  /// As for RbfInterpolant; options.smoothing_length is ignored. The values must outlive the
  /// family. `members`: how many will be asked for; of a single one nothing is kept.
  Family(std::span<const RbfSite> sites, std::span<const double> values, std::uint32_t channels,
         const RbfOptions& options, std::size_t members = 1);
  ~Family();
  Family(const Family&) = delete;
  Family& operator=(const Family&) = delete;

  /// The same, to the last bit, as the RbfInterpolant of that smoothing length; but not valid where
  /// its deviance is `deviance_limit` or more, which shows before the rest is computed.
  RbfInterpolant with_smoothing(double length,
                                double deviance_limit = std::numeric_limits<double>::infinity());

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace orbweave
