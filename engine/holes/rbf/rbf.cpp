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

// n log(y' K^-1 y / n) + log det K of values y with K = L L^T, from L^-1 y and half of log det K.
double deviance_of(double log_diagonal, const VectorXd& solved) {
  const double log_determinant = 2.0 * log_diagonal;
  const auto n = static_cast<double>(solved.size());
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
  /// `capacity`: the most centres. All sites are taken at once where they are no more than that;
  /// else centres are appended. `keeps`: all sites will be taken for several ridges.
  Fit(RbfForm form, const UniqueSites& data, std::uint32_t capacity, bool keeps)
      : form_(form),
        data_(data),
        keeps_(keeps),
        is_whole_(data.sites.size() <= capacity),
        capacity_(capacity),
        terms_(rbf_terms(form)) {}

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
    is_whole_ ? place_all() : make_room();
    return true;
  }

  bool is_whole() const { return is_whole_; }

  /// Begins anew with the special centres alone.
  void restart(double ridge) {
    ridge_ = ridge;
    deviance = 0.0;
    centers_.resize(terms_);
    phi_special_ = kernel_special_;
    add_ridge(centers_, phi_special_);
  }

  /// Takes all sites; false where the system is singular. Rows are padded to whole vectors.
  bool take_all() {
    lower_ = keeps_ ? kernel_rest_ : kernel_of_rest();
    for (Index i = 0; i < lower_.cols() && ridge_ > 0.0; ++i)
      if (data_.exact[rest_[i]] == 0) lower_(i, i) += ridge_;
    g_ = phi_rest_;
    for (int t = 0; t < terms_; ++t)
      for (int l = 0; l < terms_; ++l) g_.col(t) -= phi_special_(l, t) * p_.col(l);
    rbf_loops().subtract(padded(),
                         {p_.data(), g_.data(), phi_rest_.data(), static_cast<std::size_t>(terms_)},
                         column_sums_.data());
    if (!rbf_loops().factor(padded())) return false;
    centers_.insert(centers_.end(), rest_.begin(), rest_.end());
    return true;
  }

  /// Adds centres; false (and nothing added) where the system is singular then.
  bool append(std::span<const std::uint32_t> added) {
    const Index m = others();
    const Index b = static_cast<Index>(added.size());
    if (b == 0) return true;
    const std::span<const std::uint32_t> special(centers_.data(), terms_);
    const std::span<const std::uint32_t> present(centers_.data() + terms_, m);
    const MatrixXd p = lagrange(added);
    const MatrixXd phi = kernel_matrix(added, special);
    const MatrixXd g = phi - p * phi_special_;
    MatrixXd corner = kernel_matrix(added, added);
    add_ridge(added, corner);
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
      const auto p = p_.topRows(m);
      MatrixXd x = MatrixXd::Zero(is_whole_ ? lower_.rows() : m, f.cols());
      x.topRows(m) = f.bottomRows(m) - p * f.topRows(terms_);
      substitute(x);
      deviance = deviance_of(log_of_diagonal(), x.col(0).head(m));
      if (deviance >= deviance_limit) return false;
      substitute_transposed(x);
      weights.bottomRows(m) = x.topRows(m);
      weights.topRows(terms_) = -(p.transpose() * x.topRows(m));
      polynomial -= g_.topRows(m).transpose() * x.topRows(m);
      condition = estimate_condition();
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

  void make_room() {
    const Index rows = std::max<Index>(0, static_cast<Index>(capacity_) - terms_);
    lower_.resize(rows, rows);
    p_.resize(rows, terms_);
    g_.resize(rows, terms_);
    column_sums_ = VectorXd::Zero(rows);
  }

  /// What the sites have with each other, whatever the ridge, in padded columns.
  void place_all() {
    std::vector<std::uint8_t> is_special(data_.sites.size(), 0);
    for (const std::uint32_t center : centers_) is_special[center] = 1;
    for (std::uint32_t i = 0; i < is_special.size(); ++i)
      if (is_special[i] == 0) rest_.push_back(i);
    const Index n = static_cast<Index>(rest_.size());
    const Index stride = (n + 3) / 4 * 4;
    p_ = MatrixXd::Zero(stride, terms_);
    p_.topRows(n) = lagrange(rest_);
    places_of_rest_ = MatrixXd::Zero(stride, 3);
    for (int axis = 0; axis < 3; ++axis)
      for (Index i = 0; i < n; ++i) places_of_rest_(i, axis) = data_.sites[rest_[i]][axis];
    phi_rest_.resize(stride, terms_);
    for (int t = 0; t < terms_; ++t) fill_with_kernel(phi_rest_, t, centers_[t], 0);
    if (keeps_) kernel_rest_ = kernel_of_rest();
    column_sums_ = VectorXd::Zero(stride);
  }

  /// Of the sites that are not special, the lower triangle alone.
  MatrixXd kernel_of_rest() const {
    const Index n = static_cast<Index>(rest_.size());
    MatrixXd kernel = MatrixXd::Zero(places_of_rest_.rows(), n);
    for (Index j = 0; j < n; ++j) fill_with_kernel(kernel, j, rest_[j], j / 4 * 4);
    return kernel;
  }

  /// Rows from `first` on of a padded column: what the sites that are not special have with a site.
  void fill_with_kernel(MatrixXd& to, Index column, std::uint32_t site, Index first) const {
    const Vec3 x = data_.sites[site];
    const RbfColumns places{places_of_rest_.col(0).data() + first,
                            places_of_rest_.col(1).data() + first,
                            places_of_rest_.col(2).data() + first, nullptr,
                            static_cast<std::size_t>(to.rows() - first)};
    rbf_loops().kernel_at(form_, std::array{x.x, x.y, x.z}.data(), places,
                          to.col(column).data() + first);
    to.col(column).tail(to.rows() - static_cast<Index>(rest_.size())).setZero();
  }

  PaddedMatrix padded() {
    return {lower_.data(), static_cast<std::size_t>(lower_.cols()),
            static_cast<std::size_t>(lower_.rows())};
  }

  auto appended() { return lower_.topLeftCorner(others(), others()); }

  /// x = L^-1 x, and x = L'^-1 x.
  template <class Columns>
  void substitute(Columns& x) {
    if (!is_whole_) return appended().template triangularView<Eigen::Lower>().solveInPlace(x);
    for (Index c = 0; c < x.cols(); ++c) rbf_loops().solve(padded(), x.col(c).data());
  }
  template <class Columns>
  void substitute_transposed(Columns& x) {
    if (!is_whole_)
      return appended().template triangularView<Eigen::Lower>().transpose().solveInPlace(x);
    for (Index c = 0; c < x.cols(); ++c) rbf_loops().solve_transposed(padded(), x.col(c).data());
  }

  /// The sum of the logarithms of L's diagonal, of which a padded factor holds the inverses.
  double log_of_diagonal() const {
    double sum = 0.0;
    for (Index i = 0; i < others(); ++i) sum += rbf_log(lower_(i, i));
    return is_whole_ ? -sum : sum;
  }

  // 1-norm condition of K, after Hager, Condition Estimates, SIAM J. Sci. Stat. Comput. 1984.
  double estimate_condition() {
    const Index n = others();
    const auto solve = [this](VectorXd& x) {
      substitute(x);
      substitute_transposed(x);
    };
    VectorXd x = VectorXd::Zero(is_whole_ ? lower_.rows() : n);
    x.head(n).setConstant(1.0 / static_cast<double>(n));
    double inverse_norm = 0.0;
    for (int step = 0; step < 5; ++step) {
      VectorXd y = x;
      solve(y);
      const double estimate = y.lpNorm<1>();
      if (!(estimate > inverse_norm)) break;
      inverse_norm = estimate;
      VectorXd z = y.unaryExpr([](double v) { return v < 0.0 ? -1.0 : 1.0; });
      z.tail(z.size() - n).setZero();
      solve(z);
      Index best = 0;
      z.cwiseAbs().maxCoeff(&best);
      x.setZero();
      x[best] = 1.0;
    }
    return column_sums_.head(n).maxCoeff() * inverse_norm;
  }

  RbfForm form_;
  const UniqueSites& data_;
  bool keeps_ = false;
  bool is_whole_ = false;
  std::uint32_t capacity_ = 0;
  double ridge_ = 0.0;
  int terms_ = 0;
  std::vector<std::uint32_t> centers_;  // the special ones first
  std::vector<std::uint32_t> rest_;     // all others, where all are taken
  MatrixXd places_of_rest_;             // x, y, z
  MatrixXd kernel_rest_;                // of these, where it is kept
  MatrixXd phi_rest_;                   // of these and the special ones
  MatrixXd to_monomials_;               // from values at the special centres
  MatrixXd kernel_special_;
  MatrixXd phi_special_;  // with the ridge
  MatrixXd lower_;        // Cholesky factor of K, lower triangle; padded where all are taken
  MatrixXd p_;            // p_l at the other centres
  MatrixXd g_;            // phi(x, s_l) - sum_m p_m(x) phi(s_m, s_l) at them
  VectorXd column_sums_;  // of |K|
};

struct RbfInterpolant::Family::State {
  RbfInterpolant blank;  // with the frame
  std::span<const double> values;
  RbfForm form{};
  UniqueSites data;
  std::uint32_t cap = 0;
  std::optional<Fit> fit;  // where the sites determine an interpolant

  void measure(RbfInterpolant& interpolant) const;
};

RbfInterpolant::Family::Family(std::span<const RbfSite> sites, std::span<const double> values,
                               std::uint32_t channels, const RbfOptions& options,
                               std::size_t members)
    : state_(new State{RbfInterpolant(channels, options), values, {}, {}, 0, std::nullopt}) {
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
  state_->fit.emplace(state_->form, state_->data, state_->cap, members > 1);
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
  member.valid_ = state_->fit->is_whole() ? member.use_all(*state_->fit, deviance_limit)
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
  if (!fit.take_all() || !fit.solve(deviance_limit)) return false;
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
