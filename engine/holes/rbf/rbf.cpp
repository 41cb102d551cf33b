#include "engine/holes/rbf/rbf.h"

// Holes are the parallel tasks; a solve runs on its own thread.
#define EIGEN_DONT_PARALLELIZE
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "engine/holes/rbf/block_sizes.h"
#include "engine/holes/rbf/rbf_centers.h"
#include "engine/holes/rbf/rbf_kernel.h"

namespace orbweave {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Sites this much closer to one conic or plane than to a general position leave the polynomial
// to rounding.
constexpr double kLeastPivot = 1e-9;
// Beyond it nothing but rounding is left of the weights.
constexpr double kMostCondition = 1e15;
// The first subset of a greedy choice is this share of the cap.
constexpr std::uint32_t kFirstShare = 6;
constexpr std::size_t kBlock = 256;

// 1-norm condition of K = L L^T from its 1-norm, after Hager, Condition Estimates, SIAM J. Sci.
// Stat. Comput. 1984.
double estimate_condition(const Eigen::Ref<const MatrixXd>& lower, double norm) {
  const Index n = lower.rows();
  const auto solve = [&lower](VectorXd& x) {
    lower.triangularView<Eigen::Lower>().solveInPlace(x);
    lower.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  };
  VectorXd x = VectorXd::Constant(n, 1.0 / static_cast<double>(n));
  double inverse_norm = 0.0;
  for (int step = 0; step < 5; ++step) {
    VectorXd y = x;
    solve(y);
    const double estimate = y.lpNorm<1>();
    if (!(estimate > inverse_norm)) break;
    inverse_norm = estimate;
    VectorXd z = y.unaryExpr([](double v) { return v < 0.0 ? -1.0 : 1.0; });
    solve(z);
    Index best = 0;
    z.cwiseAbs().maxCoeff(&best);
    x.setZero();
    x[best] = 1.0;
  }
  return norm * inverse_norm;
}

// In four sums, so that additions need not wait for each other.
double sum_of_products(std::span<const double> a, const double* b) {
  std::array<double, 4> sums{};
  std::size_t i = 0;
  for (; i + 4 <= a.size(); i += 4) {
    for (std::size_t k = 0; k < 4; ++k) sums[k] += a[i + k] * b[i + k];
  }
  for (; i < a.size(); ++i) sums[0] += a[i] * b[i];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

// n log(y' K^-1 y / n) + log det K of values y with K = L L^T, from L^-1 y.
double deviance_of(const Eigen::Ref<const MatrixXd>& lower, const VectorXd& solved) {
  double log_determinant = 0.0;
  for (Index i = 0; i < lower.rows(); ++i) log_determinant += 2.0 * rbf_log(lower(i, i));
  const auto n = static_cast<double>(lower.rows());
  const double mean = std::max(solved.squaredNorm() / n, std::numeric_limits<double>::min());
  return n * rbf_log(mean) + log_determinant;
}

}  // namespace

// The system and its centres. The polynomial is eliminated with as many special centres as it has
// terms: with p_l the polynomial that is 1 at special centre s_l and 0 at the others,
//   K(x, y) = phi(x, y) - sum p_l(x) phi(s_l, y) - sum p_l(y) phi(x, s_l)
//             + sum sum p_l(x) p_m(y) phi(s_l, s_m)
// is positive definite on the other centres (Beatson, Light, Billings: Fast Solution of the Radial
// Basis Function Interpolation Equations, SIAM J. Sci. Comput. 2000, section 2). So Cholesky does:
// half the work of an LU of the saddle system, stable without pivoting, and centres are added by
// appending rows to the factor, so that greedy rounds cost no more than the last solve alone.
class RbfInterpolant::Fit {
 public:
  /// `keeps`: what append() computes for the first centres is kept for the next ridge.
  Fit(RbfForm form, const UniqueSites& data, std::uint32_t capacity, bool keeps)
      : form_(form), data_(data), keeps_(keeps), terms_(rbf_terms(form)) {
    const Index rows = std::max<Index>(0, static_cast<Index>(capacity) - terms_);
    lower_.resize(rows, rows);
    p_.resize(rows, terms_);
    g_.resize(rows, terms_);
    column_sums_ = VectorXd::Zero(rows);
  }

  /// Chooses the special centres; false where the sites do not determine the polynomial.
  bool start() {
    const Index n = static_cast<Index>(data_.sites.size());
    if (n < terms_) return false;
    MatrixXd monomials(terms_, n);
    for (Index i = 0; i < n; ++i) {
      const auto row = rbf_monomials(form_, data_.sites[i]);
      for (int t = 0; t < terms_; ++t) monomials(t, i) = row[t];
    }
    const Eigen::ColPivHouseholderQR<MatrixXd> qr(monomials);
    const auto pivots = qr.matrixR().diagonal().head(terms_).cwiseAbs();
    if (!(pivots.minCoeff() > kLeastPivot * pivots.maxCoeff())) return false;
    MatrixXd special(terms_, terms_);
    for (int t = 0; t < terms_; ++t) {
      centers_.push_back(static_cast<std::uint32_t>(qr.colsPermutation().indices()[t]));
      special.row(t) = monomials.col(centers_.back()).transpose();
    }
    to_monomials_ = special.inverse();
    kernel_special_ = kernel_matrix(centers_, centers_);
    return true;
  }

  /// Begins anew with the special centres alone.
  void restart(double ridge) {
    ridge_ = ridge;
    deviance = 0.0;
    centers_.resize(terms_);
    phi_special_ = kernel_special_;
    add_ridge(centers_, phi_special_);
  }

  /// Adds centres; false (and nothing added) where the system is singular then.
  bool append(std::span<const std::uint32_t> added) {
    const Index m = others();
    const Index b = static_cast<Index>(added.size());
    if (b == 0) return true;
    const std::span<const std::uint32_t> special(centers_.data(), terms_);
    const std::span<const std::uint32_t> present(centers_.data() + terms_, m);
    if (!is_kept(added)) keep(added, special);
    const MatrixXd& p = kept_.p;
    const MatrixXd& phi = kept_.phi;
    const MatrixXd g = phi - p * phi_special_;
    MatrixXd kernel = keeps_ ? kept_.kernel : std::move(kept_.kernel);
    add_ridge(added, kernel);
    MatrixXd corner = std::move(kernel);
    corner.noalias() -= p * g.transpose();
    corner.noalias() -= phi * p.transpose();
    VectorXd sums = corner.cwiseAbs().rowwise().sum();
    if (m > 0) {
      auto left = lower_.block(m, 0, b, m);
      left = kernel_matrix(added, present);
      left.noalias() -= p * g_.topRows(m).transpose();
      left.noalias() -= phi * p_.topRows(m).transpose();
      sums += left.cwiseAbs().rowwise().sum();
      column_sums_.head(m) += left.cwiseAbs().colwise().sum().transpose();
      lower_.topLeftCorner(m, m)
          .triangularView<Eigen::Lower>()
          .transpose()
          .solveInPlace<Eigen::OnTheRight>(left);
      corner.selfadjointView<Eigen::Lower>().rankUpdate(left, -1.0);
    }
    const Eigen::LLT<Eigen::Ref<MatrixXd>> factor(corner);
    if (factor.info() != Eigen::Success) return false;
    lower_.block(m, m, b, b) = corner;
    p_.middleRows(m, b) = p;
    g_.middleRows(m, b) = g;
    column_sums_.segment(m, b) = sums;
    centers_.insert(centers_.end(), added.begin(), added.end());
    return true;
  }

  /// Weights and polynomial for the centres present; false where they are not finite, or where the
  /// deviance is at the limit.
  bool solve(double deviance_limit) {
    const Index m = others();
    const MatrixXd f = values_of(centers_);
    weights = MatrixXd::Zero(m + terms_, f.cols());
    polynomial = f.topRows(terms_);
    condition = 1.0;
    if (m > 0) {
      const auto lower = lower_.topLeftCorner(m, m);
      const auto p = p_.topRows(m);
      MatrixXd x = f.bottomRows(m) - p * f.topRows(terms_);
      lower.triangularView<Eigen::Lower>().solveInPlace(x);
      deviance = deviance_of(lower, x.col(0));
      if (deviance >= deviance_limit) return false;
      lower.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
      weights.bottomRows(m) = x;
      weights.topRows(terms_) = -(p.transpose() * x);
      polynomial -= g_.topRows(m).transpose() * x;
      condition = estimate_condition(lower, column_sums_.head(m).maxCoeff());
    }
    polynomial = to_monomials_ * polynomial;
    return weights.allFinite() && polynomial.allFinite() && condition < kMostCondition;
  }

  const std::vector<std::uint32_t>& centers() const { return centers_; }
  const UniqueSites& data() const { return data_; }

  MatrixXd weights;     // centres x channels
  MatrixXd polynomial;  // terms x channels
  double condition = 0.0;
  double deviance = 0.0;

 private:
  Index others() const { return static_cast<Index>(centers_.size()) - terms_; }

  MatrixXd values_of(std::span<const std::uint32_t> which) const {
    MatrixXd f(static_cast<Index>(which.size()), static_cast<Index>(data_.channels));
    for (Index i = 0; i < f.rows(); ++i) {
      for (Index c = 0; c < f.cols(); ++c) f(i, c) = data_.values[which[i] * f.cols() + c];
    }
    return f;
  }

  MatrixXd lagrange(std::span<const std::uint32_t> which) const {
    MatrixXd monomials(static_cast<Index>(which.size()), terms_);
    for (Index i = 0; i < monomials.rows(); ++i) {
      const auto row = rbf_monomials(form_, data_.sites[which[i]]);
      for (int t = 0; t < terms_; ++t) monomials(i, t) = row[t];
    }
    return monomials * to_monomials_;
  }

  MatrixXd kernel_matrix(std::span<const std::uint32_t> rows,
                         std::span<const std::uint32_t> columns) const {
    MatrixXd phi(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
    for (Index j = 0; j < phi.cols(); ++j) {
      const Vec3 center = data_.sites[columns[j]];
      double* column = phi.col(j).data();
      for (Index i = 0; i < phi.rows(); ++i) {
        column[i] = squared_norm(data_.sites[rows[i]] - center);
      }
      rbf_loops().kernel(form_, column, rows.size());
    }
    return phi;
  }

  /// To the kernel of centres with themselves.
  void add_ridge(std::span<const std::uint32_t> centers, MatrixXd& kernel) const {
    if (!(ridge_ > 0.0)) return;
    for (Index i = 0; i < kernel.rows(); ++i)
      if (data_.exact[centers[i]] == 0) kernel(i, i) += ridge_;
  }

  /// What centres that are added have with the special ones and with themselves, whatever the
  /// ridge.
  struct Added {
    std::vector<std::uint32_t> centers;
    MatrixXd p, phi, kernel;
  };

  bool is_kept(std::span<const std::uint32_t> added) const {
    return keeps_ &&
           std::equal(added.begin(), added.end(), kept_.centers.begin(), kept_.centers.end());
  }
  void keep(std::span<const std::uint32_t> added, std::span<const std::uint32_t> special) {
    kept_ = {{added.begin(), added.end()},
             lagrange(added),
             kernel_matrix(added, special),
             kernel_matrix(added, added)};
  }

  RbfForm form_;
  const UniqueSites& data_;
  bool keeps_ = false;
  double ridge_ = 0.0;
  int terms_ = 0;
  Added kept_;                          // the last ones
  std::vector<std::uint32_t> centers_;  // the special ones first
  MatrixXd to_monomials_;               // from values at the special centres
  MatrixXd kernel_special_;
  MatrixXd phi_special_;  // with the ridge
  MatrixXd lower_;        // Cholesky factor of K, lower triangle
  MatrixXd p_;            // p_l at the other centres
  MatrixXd g_;            // phi(x, s_l) - sum_m p_m(x) phi(s_m, s_l) at them
  VectorXd column_sums_;  // of |K|
};

struct RbfInterpolant::Family::State {
  RbfInterpolant blank;  // with the frame
  std::span<const double> values;
  std::size_t members = 1;
  RbfForm form{};
  UniqueSites data;
  std::uint32_t cap = 0;
  std::optional<Fit> fit;  // where the sites determine an interpolant

  bool takes_all() const { return data.sites.size() <= cap; }
  void measure(RbfInterpolant& interpolant) const;
};

RbfInterpolant::Family::Family(std::span<const RbfSite> sites, std::span<const double> values,
                               std::uint32_t channels, const RbfOptions& options,
                               std::size_t members)
    : state_(
          new State{RbfInterpolant(channels, options), values, members, {}, {}, 0, std::nullopt}) {
  const auto finite = [](double v) { return std::isfinite(v); };
  if (sites.empty() || channels == 0 || values.size() != sites.size() * channels) return;
  if (!std::all_of(values.begin(), values.end(), finite)) return;
  if (!state_->blank.set_frame(sites)) return;
  fix_block_sizes();
  std::vector<Vec3> in_frame(sites.size());
  std::transform(sites.begin(), sites.end(), in_frame.begin(),
                 [this](Vec3 x) { return state_->blank.scaled(x); });
  state_->data = merge_duplicates(in_frame, values, channels, options.exact_sites);
  state_->form = rbf_form(options.dimension, options.kernel);
  state_->cap = std::max(options.max_sites, static_cast<std::uint32_t>(rbf_terms(state_->form)));
  const auto unique = static_cast<std::uint32_t>(state_->data.sites.size());
  state_->fit.emplace(state_->form, state_->data, std::min(unique, state_->cap),
                      members > 1 && state_->takes_all());
  if (!state_->fit->start()) state_->fit.reset();
}

RbfInterpolant::Family::~Family() = default;

RbfInterpolant RbfInterpolant::Family::with_smoothing(double length, double deviance_limit) {
  RbfInterpolant member = state_->blank;
  RbfOptions& options = member.options_;
  options.smoothing_length = length;
  if (!state_->fit) return member;
  state_->fit->restart(
      rbf_ridge(state_->form, length / member.scale_, options.site_spacing / member.scale_));
  member.valid_ = state_->takes_all() ? member.use_all(*state_->fit, deviance_limit)
                                      : member.choose_greedily(*state_->fit, state_->cap) &&
                                            !(member.deviance_ >= deviance_limit);
  if (member.valid_ && options.measure) state_->measure(member);
  return member;
}

void RbfInterpolant::Family::State::measure(RbfInterpolant& interpolant) const {
  const std::vector<double> at_sites = interpolant.values_at(data.sites);
  const std::size_t channels = interpolant.channels_;
  for (std::size_t i = 0; i * channels < values.size(); ++i) {
    interpolant.residual_ =
        std::max(interpolant.residual_, std::abs(at_sites[data.of[i]] - values[i * channels]));
  }
}

RbfInterpolant::RbfInterpolant(std::span<const RbfSite> sites, std::span<const double> values,
                               std::uint32_t channels, const RbfOptions& options)
    : RbfInterpolant(
          Family(sites, values, channels, options).with_smoothing(options.smoothing_length)) {}

// Centre and half the extent of the sites' box; false where it is not finite.
bool RbfInterpolant::set_frame(std::span<const RbfSite> sites) {
  Vec3 low = sites[0];
  Vec3 high = sites[0];
  for (const Vec3 site : sites) {
    if (!is_finite(site)) return false;
    for (int axis = 0; axis < options_.dimension; ++axis) {
      low[axis] = std::min(low[axis], site[axis]);
      high[axis] = std::max(high[axis], site[axis]);
    }
  }
  const Vec3 extent = high - low;
  const double largest = std::max({extent.x, extent.y, options_.dimension == 2 ? 0.0 : extent.z});
  center_ = low + 0.5 * extent;
  scale_ = 0.5 * largest;
  return scale_ > 0.0 && std::isfinite(scale_) && std::isfinite(1.0 / scale_);
}

RbfSite RbfInterpolant::scaled(RbfSite x) const {
  const Vec3 d = (x - center_) / scale_;
  return {d.x, d.y, options_.dimension == 2 ? 0.0 : d.z};
}

// Keeps the solution of `fit`.
void RbfInterpolant::take(const Fit& fit) {
  for (std::vector<double>& axis : centers_) axis.clear();
  for (const std::uint32_t center : fit.centers()) {
    for (int axis = 0; axis < 3; ++axis) centers_[axis].push_back(fit.data().sites[center][axis]);
  }
  weights_.assign(fit.weights.data(), fit.weights.data() + fit.weights.size());
  polynomial_.assign(fit.polynomial.data(), fit.polynomial.data() + fit.polynomial.size());
  condition_ = fit.condition;
  deviance_ = fit.deviance;
}

bool RbfInterpolant::use_all(Fit& fit, double deviance_limit) {
  std::vector<std::uint8_t> present(fit.data().sites.size(), 0);
  for (const std::uint32_t center : fit.centers()) present[center] = 1;
  std::vector<std::uint32_t> rest;
  for (std::uint32_t i = 0; i < present.size(); ++i) {
    if (present[i] == 0) rest.push_back(i);
  }
  if (!fit.append(rest) || !fit.solve(deviance_limit)) return false;
  take(fit);
  return true;
}

// Carr et al., section 5.1: fit a few centres, add those where the fit is worst, and again.
bool RbfInterpolant::choose_greedily(Fit& fit, std::uint32_t cap) {
  const std::vector<Vec3>& sites = fit.data().sites;
  FarthestPoints spread(sites, fit.centers());
  std::vector<std::uint32_t> added;
  while (fit.centers().size() + added.size() < std::max(cap / kFirstShare, std::min(cap, 32u))) {
    const auto next = spread.next();
    if (!next) break;
    added.push_back(*next);
  }
  const double first_spacing = spread.radius();
  const auto first_count = static_cast<double>(fit.centers().size() + added.size());
  bool solved = false;
  while (fit.append(added) && fit.solve(std::numeric_limits<double>::infinity())) {
    take(fit);
    solved = true;
    const std::size_t count = fit.centers().size();
    const std::vector<double> residuals = residuals_at(fit);
    std::vector<std::uint32_t> bad;
    for (std::uint32_t i = 0; i < sites.size(); ++i) {
      if (residuals[i] > options_.tolerance) bad.push_back(i);
    }
    if (bad.empty() || count >= cap) break;
    const std::size_t batch = std::min<std::size_t>(cap - count, count);
    const double spacing =
        first_spacing * std::sqrt(first_count / static_cast<double>(count + batch));
    added = worst_sites(sites, residuals, std::move(bad), batch, 0.5 * spacing);
  }
  return solved;
}

// |s - value| of channel 0 at the unique sites; 0 at the centres, which cannot be added again.
std::vector<double> RbfInterpolant::residuals_at(const Fit& fit) const {
  const UniqueSites& data = fit.data();
  std::vector<double> residuals = values_at(data.sites);
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    residuals[i] = std::abs(residuals[i] - data.values[i * data.channels]);
  }
  for (const std::uint32_t center : fit.centers()) residuals[center] = 0.0;
  return residuals;
}

// Channel 0 at places that are scaled already.
std::vector<double> RbfInterpolant::values_at(const std::vector<Vec3>& in_frame) const {
  std::vector<double> values(in_frame.size());
  for (std::size_t i = 0; i < values.size(); ++i) evaluate_scaled(in_frame[i], {&values[i], 1});
  return values;
}

// Centres from `first` on, a block at most, with the weights of channel 0.
RbfColumns RbfInterpolant::block_of_centers(std::size_t first) const {
  return {centers_[0].data() + first, centers_[1].data() + first, centers_[2].data() + first,
          weights_.data() + first, std::min(kBlock, centers_[0].size() - first)};
}

void RbfInterpolant::evaluate_scaled(RbfSite x, std::span<double> out) const {
  const RbfForm form = rbf_form(options_.dimension, options_.kernel);
  const auto monomials = rbf_monomials(form, x);
  const int terms = rbf_terms(form);
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c] = std::inner_product(monomials.begin(), monomials.begin() + terms,
                                polynomial_.begin() + static_cast<std::ptrdiff_t>(c) * terms, 0.0);
  }
  std::array<double, kBlock> block;
  const std::size_t count = centers_[0].size();
  for (std::size_t first = 0; first < count; first += kBlock) {
    const RbfColumns centers = block_of_centers(first);
    rbf_loops().kernel_at(form, std::array{x.x, x.y, x.z}.data(), centers, block.data());
    const std::span<const double> phi(block.data(), centers.count);
    for (std::size_t c = 0; c < out.size(); ++c) {
      out[c] += sum_of_products(phi, weights_.data() + c * count + first);
    }
  }
}

void RbfInterpolant::evaluate(RbfSite x, std::span<double> out) const {
  evaluate_scaled(scaled(x), out.first(channels_));
}

double RbfInterpolant::evaluate(RbfSite x) const {
  double value = 0.0;
  evaluate_scaled(scaled(x), {&value, 1});
  return value;
}

RbfInterpolant::ValueGradient RbfInterpolant::evaluate_with_gradient(RbfSite x) const {
  const RbfForm form = rbf_form(options_.dimension, options_.kernel);
  const RbfSite y = scaled(x);
  const auto monomials = rbf_monomials(form, y);
  const auto slopes = rbf_monomial_gradients(form, y);
  ValueGradient result;
  for (int t = 0; t < rbf_terms(form); ++t) {
    result.value += polynomial_[t] * monomials[t];
    result.gradient = result.gradient + polynomial_[t] * slopes[t];
  }
  const std::size_t count = centers_[0].size();
  for (std::size_t first = 0; first < count; first += kBlock) {
    const RbfSums sums =
        rbf_loops().sums_at(form, std::array{y.x, y.y, y.z}.data(), block_of_centers(first));
    result.value += sums.value;
    // The gradient of phi is 2 slope (y - center).
    for (int axis = 0; axis < 3; ++axis)
      result.gradient[axis] += 2.0 * (sums.slope * y[axis] - sums.slope_by_center[axis]);
  }
  result.gradient = result.gradient / scale_;
  return result;
}

}  // namespace orbweave
