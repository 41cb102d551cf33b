#include "engine/holes/patch/patch_values.h"

#include <algorithm>

#include "engine/holes/rbf/rbf.h"

namespace orbweave {
namespace {

void add_scaled(std::span<const double> row, double weight, std::span<double> sum) {
  for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += weight * row[c];
}

/// Keeps a row within the range of the rows given.
class Range {
 public:
  Range(std::span<const double> rows, std::size_t channels)
      : low_(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(channels)), high_(low_) {
    for (std::size_t i = channels; i < rows.size(); ++i) {
      const std::size_t c = i % channels;
      low_[c] = std::min(low_[c], rows[i]);
      high_[c] = std::max(high_[c], rows[i]);
    }
  }
  void clamp(std::span<double> row) const {
    for (std::size_t c = 0; c < row.size(); ++c) row[c] = std::clamp(row[c], low_[c], high_[c]);
  }

 private:
  std::vector<double> low_, high_;
};

}  // namespace

std::vector<double> values_from_corners(const HoleProblem& problem, std::span<const Vec3> points) {
  const std::size_t channels = problem.channels;
  std::vector<double> values(points.size() * channels, 0.0);
  if (channels == 0 || points.empty()) return values;
  const std::vector<double> rows = problem.values_of(problem.loop);
  const Range range(rows, channels);
  std::vector<Vec3> corners;
  for (const std::uint32_t v : problem.loop) corners.push_back(problem.positions[v]);
  std::vector<double> weights(corners.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::span<double> row = std::span(values).subspan(i * channels, channels);
    for (std::size_t k = 0; k < corners.size(); ++k)
      weights[k] = squared_norm(points[i] - corners[k]);
    // Relative to the nearest corner, so that no weight over- or underflows.
    const double nearest = *std::min_element(weights.begin(), weights.end());
    for (double& weight : weights) weight = weight > 0.0 ? nearest / weight : 1.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      add_scaled(std::span(rows).subspan(k * channels, channels), weights[k], row);
      sum += weights[k];
    }
    for (double& value : row) value /= sum;
    range.clamp(row);
  }
  return values;
}

void give_values(const HoleProblem& problem, HolePatch& patch) {
  if (!patch.lacks_values) return;
  patch.values = values_from_corners(problem, patch.positions);
  patch.lacks_values = false;
}

std::vector<double> values_from_sites(const HoleProblem& problem,
                                      std::span<const std::uint32_t> sites,
                                      std::span<const Vec3> points, const PatchOptions& options) {
  const std::size_t channels = problem.channels;
  if (channels == 0 || points.empty()) return {};
  if (sites.empty()) return values_from_corners(problem, points);
  std::vector<RbfSite> at;
  for (const std::uint32_t site : sites) at.push_back(problem.positions[site]);
  const std::vector<double> known = problem.values_of(sites);
  RbfOptions rbf_options;
  rbf_options.dimension = 3;
  rbf_options.kernel = RbfKernel::kBiharmonic;
  rbf_options.max_sites = options.max_sites;
  rbf_options.measure = false;
  const RbfInterpolant rbf(at, known, problem.channels, rbf_options);
  if (!rbf.valid()) return values_from_corners(problem, points);
  const Range range(known, channels);
  std::vector<double> values(points.size() * channels);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::span<double> row = std::span(values).subspan(i * channels, channels);
    rbf.evaluate(points[i], row);
    range.clamp(row);
  }
  return values;
}

}  // namespace orbweave
