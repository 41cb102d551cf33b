#include "engine/holes/rbf/rbf_kernel.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace orbweave {
namespace {

// Added to a distance it changes nothing but 0, which then has a finite logarithm and inverse to
// be multiplied by 0. A comparison would keep the loops below from being vectorised.
constexpr double kTiny = std::numeric_limits<double>::min();

double log_squared(double squared) { return rbf_log(squared + kTiny); }

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

void rbf_kernel(RbfForm form, std::span<double> squared) {
  switch (form) {
    case RbfForm::kPlaneBiharmonic:
      for (double& q : squared) q = 0.5 * q * log_squared(q);
      break;
    case RbfForm::kPlaneTriharmonic:
      for (double& q : squared) q = -0.5 * q * q * log_squared(q);
      break;
    case RbfForm::kSpaceBiharmonic:
      for (double& q : squared) q = -std::sqrt(q);
      break;
    case RbfForm::kSpaceTriharmonic:
      for (double& q : squared) q = q * std::sqrt(q);
      break;
  }
}

void rbf_kernel_slope(RbfForm form, std::span<double> squared, std::span<double> slope) {
  const std::size_t n = squared.size();
  switch (form) {
    case RbfForm::kPlaneBiharmonic:
      for (std::size_t i = 0; i < n; ++i) {
        const double half_log = 0.5 * log_squared(squared[i]);
        squared[i] *= half_log;
        slope[i] = half_log + 0.5;
      }
      break;
    case RbfForm::kPlaneTriharmonic:
      for (std::size_t i = 0; i < n; ++i) {
        const double q = squared[i];
        const double log = log_squared(q);
        squared[i] = -0.5 * q * q * log;
        slope[i] = -q * (log + 0.5);
      }
      break;
    case RbfForm::kSpaceBiharmonic:
      for (std::size_t i = 0; i < n; ++i) {
        const double r = std::sqrt(squared[i]);
        squared[i] = -r;
        slope[i] = -0.5 / (r + kTiny);
      }
      break;
    case RbfForm::kSpaceTriharmonic:
      for (std::size_t i = 0; i < n; ++i) {
        const double r = std::sqrt(squared[i]);
        squared[i] *= r;
        slope[i] = 1.5 * r;
      }
      break;
  }
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
