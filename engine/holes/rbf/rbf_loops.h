// The loops over the centres of radial basis functions, for several vector widths. Units compiled
// for other machines include this header: it defines nothing.
#pragma once

#include <cstddef>

namespace orbweave {

/// A kernel with the sign that makes it conditionally positive definite.
enum class RbfForm { kPlaneBiharmonic, kPlaneTriharmonic, kSpaceBiharmonic, kSpaceTriharmonic };

/// Centres in columns, and a weight of each.
struct RbfColumns {
  const double* x = nullptr;
  const double* y = nullptr;
  const double* z = nullptr;
  const double* weights = nullptr;
  std::size_t count = 0;
};

/// Sums over centres: of weights times phi, of weights times d phi / d (r^2), and of the latter
/// times the centres' coordinates.
struct RbfSums {
  double value = 0.0;
  double slope = 0.0;
  double slope_by_center[3] = {};
};

struct RbfLoops {
  /// phi of squared distances, in place.
  void (*kernel)(RbfForm form, double* squared, std::size_t count) = nullptr;
  /// phi of a place and each centre.
  void (*kernel_at)(RbfForm form, const double place[3], const RbfColumns& centers,
                    double* phi) = nullptr;
  RbfSums (*sums_at)(RbfForm form, const double place[3], const RbfColumns& centers) = nullptr;
};

RbfLoops rbf_loops_generic();
RbfLoops rbf_loops_avx2();
/// The widest that this machine has; every width computes the same bits.
const RbfLoops& rbf_loops();

}  // namespace orbweave
