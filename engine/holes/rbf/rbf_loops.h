// The loops over the centres of radial basis functions, for several vector widths. Units compiled
// for other machines include this header: it defines nothing.
#pragma once

#include <cstddef>

#include "engine/holes/rbf/padded_matrix.h"

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
  /// The lower triangle of matrix -= sum a_t b_t' + c_t a_t'. `row_sums`: the sums of magnitudes
  /// along the rows of the symmetric matrix, `stride` of them.
  void (*subtract)(const PaddedMatrix& matrix, const PaddedTerms& terms,
                   double* row_sums) = nullptr;
  /// The lower triangle becomes L of L L', its diagonal 1 / L_ii; false where the matrix is not
  /// positive definite to rounding.
  bool (*factor)(const PaddedMatrix& matrix) = nullptr;
  /// x = L^-1 x and x = L'^-1 x, of `stride` values that are 0 from `size` on.
  void (*solve)(const PaddedMatrix& factor, double* x) = nullptr;
  void (*solve_transposed)(const PaddedMatrix& factor, double* x) = nullptr;
};

RbfLoops rbf_loops_generic();
RbfLoops rbf_loops_avx2();
/// The widest that this machine has; every width computes the same bits.
const RbfLoops& rbf_loops();

}  // namespace orbweave
