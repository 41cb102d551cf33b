#include "engine/spacing/automatic_radii.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/spacing/site_points.h"
#include "engine/spacing/site_search.h"

namespace orbweave {
namespace {

constexpr std::size_t kNeighbors = 6;
/// Approximate maximum number of points measured; quantiles of more points are no better.
constexpr std::uint64_t kMeasuredPoints = 32768;
constexpr int kMostAutomaticLevels = 8;
/// Points that one thread takes at once, between two looks at the request to stop.
constexpr std::size_t kPlacesAtOnce = 256;
/// Farther from their neighbours than that, points are strays and not a sparse part.
constexpr double kFarthestPerMedian = 16.0;

/// Mean distance to the nearest neighbours of the core's selected points; with `only_sure`, of
/// those whose neighbours are all in the site for certain.
std::vector<double> mean_distances(const SpacingSite& site, std::size_t neighbors,
                                   PointSelection selection, bool only_sure,
                                   const StopToken* stop) {
  const std::vector<Vec3>& points = site.points;
  std::vector<std::uint32_t> places;
  for (std::uint32_t i = 0; i < points.size(); ++i)
    if (site.core.contains(points[i]) && selection.takes(points[i])) places.push_back(i);
  if (points.size() < 2 || places.empty()) return {};
  const SiteSearch search(points);
  const std::size_t count = std::min(neighbors, points.size() - 1);
  constexpr double kUnsure = -1.0;
  std::vector<double> means(places.size(), kUnsure);
  using Range = tbb::blocked_range<std::size_t>;
  tbb::parallel_for(Range(0, places.size(), kPlacesAtOnce), [&](const Range& range) {
    check_stop(stop);
    SiteSearch::Query query;
    std::vector<Neighbor> found;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      query.nearest(search, places[i], count + 1, found);
      const double reach = std::sqrt(found.back().squared_distance);
      if (only_sure && reach > distance_to_border(points[places[i]], site.box)) continue;
      double sum = 0.0;
      for (std::size_t k = 1; k <= count; ++k) sum += std::sqrt(found[k].squared_distance);
      means[i] = sum / static_cast<double>(count);
    }
  });
  std::erase(means, kUnsure);
  return means;
}

std::vector<double> all_mean_distances(std::span<const SpacingSite> sites, std::size_t neighbors,
                                       bool only_sure, const StopToken* stop) {
  const PointSelection selection = select_points(sites, kMeasuredPoints);
  std::vector<std::vector<double>> of_site(sites.size());
  tbb::parallel_for(std::size_t{0}, sites.size(), [&](std::size_t i) {
    of_site[i] = mean_distances(sites[i], neighbors, selection, only_sure, stop);
  });
  std::vector<double> all;
  for (const auto& part : of_site) all.insert(all.end(), part.begin(), part.end());
  std::sort(all.begin(), all.end());
  return all;
}

double quantile(const std::vector<double>& sorted, std::size_t percent) {
  return sorted[(sorted.size() - 1) * percent / 100];
}

/// What the largest ball must span: all but a fiftieth of the points and all but a tenth of the
/// surface. (A part a hundred times sparser than the rest holds hardly any points.)
double sparse_spacing(const std::vector<double>& means) {
  const double far = kFarthestPerMedian * quantile(means, 50);
  double area = 0.0, below = 0.0;
  for (const double mean : means)
    if (mean <= far) area += mean * mean;
  double by_area = quantile(means, 50);
  for (const double mean : means) {
    below += mean * mean;
    if (mean > far || below > 0.9 * area) break;
    by_area = mean;
  }
  return std::max(by_area, std::min(far, quantile(means, 98)));
}

/// One where a step of growth would reach the sparse parts, else as many as lead there.
int levels_for(double spacing, double sparse) {
  if (sparse <= kRadiusGrowth * spacing) return 1;
  int levels = 1;
  for (double reach = spacing; reach < sparse && levels < kMostAutomaticLevels; ++levels)
    reach *= kRadiusGrowth;
  return levels;
}

std::string density_reason(const std::vector<double>& means, int levels) {
  const double sparse = sparse_spacing(means);
  const std::string times = short_text(sparse / quantile(means, 50)) + " times the median";
  if (levels == 1)
    return "; the sparser parts have " + short_text(sparse) + ", " + times +
           ", which one radius serves";
  return "; the sparser parts have " + short_text(sparse) + ", " + times + ", to which " +
         std::to_string(levels) + " levels lead";
}

std::string reason_of(const RadiiChoice& choice, const std::vector<double>& means,
                      std::uint64_t points) {
  const bool lone = choice.radii.size() == 1;
  const double sparse = quantile(means, 95);
  std::string reason = "the mean distance to the " + std::to_string(kNeighbors) +
                       " nearest neighbours, measured at " + std::to_string(means.size()) + " of " +
                       std::to_string(points) + " points, has the median " +
                       short_text(choice.spacing) + " and the ninth decile " +
                       short_text(quantile(means, 90)) + "; the radius is " +
                       short_text(kRadiusPerSpacing) + " times the " + (lone ? "latter" : "former");
  if (!lone) reason += " and then grows by " + short_text(kRadiusGrowth) + " from level to level";
  if (sparse > choice.radii.back())
    reason += "; one point in twenty is more than " + short_text(sparse) +
              " from its neighbours and may need a larger radius";
  return reason;
}

}  // namespace

std::vector<double> neighbor_distances(std::span<const SpacingSite> sites, std::size_t neighbors,
                                       const StopToken* stop) {
  const DistinctSites distinct(sites, stop);
  std::vector<double> means = all_mean_distances(distinct.all(), neighbors, true, stop);
  if (means.empty()) means = all_mean_distances(distinct.all(), neighbors, false, stop);
  return means;
}

RadiiChoice choose_radii(std::span<const SpacingSite> sites, std::uint64_t points, int levels,
                         const StopToken* stop) {
  RadiiChoice choice;
  const std::vector<double> means = neighbor_distances(sites, kNeighbors, stop);
  if (means.empty()) {
    choice.reason = points < 2 ? "there are fewer than two points"
                               : "no two different points were found near one another";
    return choice;
  }
  choice.spacing = quantile(means, 50);
  const bool by_density = levels == 0;
  if (by_density) levels = levels_for(choice.spacing, sparse_spacing(means));
  double ball_radius = kRadiusPerSpacing * (levels == 1 ? quantile(means, 90) : choice.spacing);
  for (int level = 0; level < levels; ++level) {
    choice.radii.push_back(ball_radius);
    ball_radius *= kRadiusGrowth;
  }
  choice.reason = reason_of(choice, means, points);
  if (by_density) choice.reason += density_reason(means, levels);
  return choice;
}

}  // namespace orbweave
