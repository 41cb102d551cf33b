#include "engine/holes/rbf/rbf_kernel.h"

#include <numbers>

namespace orbweave {
namespace {

bool is_plane(RbfForm form) {
  return form == RbfForm::kPlaneBiharmonic || form == RbfForm::kPlaneTriharmonic;
}

bool is_quadratic(RbfForm form) {
  return form == RbfForm::kPlaneTriharmonic || form == RbfForm::kSpaceTriharmonic;
}

}  // namespace

RbfForm rbf_form(int dimension, RbfKernel kernel) {
  const bool biharmonic = kernel == RbfKernel::kBiharmonic;
  if (dimension == 2) {
    return biharmonic ? RbfForm::kPlaneBiharmonic : RbfForm::kPlaneTriharmonic;
  }
  return biharmonic ? RbfForm::kSpaceBiharmonic : RbfForm::kSpaceTriharmonic;
}

// phi is a multiple c of the fundamental solution of (-Laplace)^p. Minimising
// sum (s - f)^2 + ridge <s, s> at density 1 / spacing^d damps the frequency k by
// 1 / (1 + ridge spacing^d k^(2p) / c), which is one half at k = 1 / length.
double rbf_ridge(RbfForm form, double length, double spacing) {
  if (!(length > 0.0 && spacing > 0.0)) return 0.0;
  const double ratio = length / spacing;
  const double biharmonic = ratio * ratio * ratio * ratio;
  const double triharmonic = biharmonic * ratio * ratio;
  switch (form) {
    case RbfForm::kPlaneBiharmonic:
      return 8.0 * std::numbers::pi * biharmonic * spacing * spacing;
    case RbfForm::kPlaneTriharmonic:
      return 128.0 * std::numbers::pi * triharmonic * spacing * spacing * spacing * spacing;
    case RbfForm::kSpaceBiharmonic:
      return 8.0 * std::numbers::pi * biharmonic * spacing;
    case RbfForm::kSpaceTriharmonic:
      return 96.0 * std::numbers::pi * triharmonic * spacing * spacing * spacing;
  }
  return 0.0;
}

int rbf_terms(RbfForm form) {
  if (is_plane(form)) return is_quadratic(form) ? 6 : 3;
  return is_quadratic(form) ? 10 : 4;
}

std::array<double, kRbfTerms> rbf_monomials(RbfForm form, Vec3 x) {
  if (is_plane(form)) return {1.0, x.x, x.y, x.x * x.x, x.x * x.y, x.y * x.y, 0.0, 0.0, 0.0, 0.0};
  return {1.0, x.x, x.y, x.z, x.x * x.x, x.y * x.y, x.z * x.z, x.x * x.y, x.y * x.z, x.z * x.x};
}

std::array<Vec3, kRbfTerms> rbf_monomial_gradients(RbfForm form, Vec3 x) {
  if (is_plane(form)) {
    return {Vec3{}, {1, 0, 0}, {0, 1, 0}, {2 * x.x, 0, 0}, {x.y, x.x, 0}, {0, 2 * x.y, 0}};
  }
  return {Vec3{},          {1, 0, 0},       {0, 1, 0},     {0, 0, 1},     {2 * x.x, 0, 0},
          {0, 2 * x.y, 0}, {0, 0, 2 * x.z}, {x.y, x.x, 0}, {0, x.z, x.y}, {x.z, 0, x.x}};
}

}  // namespace orbweave
