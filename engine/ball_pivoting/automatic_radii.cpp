#include "engine/ball_pivoting/automatic_radii.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <tuple>

#include "engine/normals/point_tree.h"

namespace orbweave {
namespace {

constexpr std::size_t kNeighbors = 6;
/// About so many points are measured at most; quantiles of more are no better.
constexpr std::uint64_t kMeasuredPoints = 32768;

/// Which points are measured: those whose hash is at most `last`. Only signs and mantissas are
/// hashed, so a cloud scaled by a power of two is measured at the same points.
struct Selection {
  std::uint64_t last = ~std::uint64_t{0};

  bool takes(Vec3 p) const {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto bits = std::bit_cast<std::uint64_t>(p[axis] == 0.0 ? 0.0 : p[axis]);
      hash = (hash ^ (bits & 0x800FFFFFFFFFFFFFu)) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 32;
    }
    return hash * 0xBF58476D1CE4E5B9u <= last;
  }
};

/// Sorts, so that sums do not depend on how points came, and drops duplicates.
void make_distinct(std::vector<Vec3>& points) {
  std::sort(points.begin(), points.end(),
            [](Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
}

std::vector<SpacingSite> distinct_sites(std::span<const SpacingSite> sites) {
  std::vector<SpacingSite> distinct(sites.begin(), sites.end());
  tbb::parallel_for(std::size_t{0}, distinct.size(),
                    [&](std::size_t i) { make_distinct(distinct[i].points); });
  return distinct;
}

Selection selection_for(std::span<const SpacingSite> sites) {
  std::uint64_t points = 0;
  for (const SpacingSite& site : sites) points += site.points.size();
  if (points <= kMeasuredPoints) return {};
  return {~std::uint64_t{0} / points * kMeasuredPoints};
}

double distance_to_border(Vec3 p, const Box& box) {
  double distance = p.x - box.min.x;
  for (int axis = 0; axis < 3; ++axis)
    distance = std::min({distance, p[axis] - box.min[axis], box.max[axis] - p[axis]});
  return distance;
}

/// Mean distance to the nearest neighbours of the core's selected points; with `only_sure`, of
/// those whose neighbours are all in the site for certain.
std::vector<double> mean_distances(const SpacingSite& site, std::size_t neighbors,
                                   Selection selection, bool only_sure) {
  const std::vector<Vec3>& points = site.points;
  std::vector<double> means;
  if (points.size() < 2) return means;
  const PointTree tree(points);
  std::vector<Neighbor> found;
  const std::size_t count = std::min(neighbors, points.size() - 1);
  for (const Vec3& p : points) {
    if (!site.core.contains(p) || !selection.takes(p)) continue;
    tree.nearest(p, count + 1, found);
    const double reach = std::sqrt(found.back().squared_distance);
    if (only_sure && reach > distance_to_border(p, site.box)) continue;
    double sum = 0.0;
    for (std::size_t i = 1; i <= count; ++i) sum += std::sqrt(found[i].squared_distance);
    means.push_back(sum / static_cast<double>(count));
  }
  return means;
}

std::vector<double> all_mean_distances(std::span<const SpacingSite> sites, std::size_t neighbors,
                                       bool only_sure) {
  const Selection selection = selection_for(sites);
  std::vector<std::vector<double>> of_site(sites.size());
  tbb::parallel_for(std::size_t{0}, sites.size(), [&](std::size_t i) {
    of_site[i] = mean_distances(sites[i], neighbors, selection, only_sure);
  });
  std::vector<double> all;
  for (const auto& part : of_site) all.insert(all.end(), part.begin(), part.end());
  std::sort(all.begin(), all.end());
  return all;
}

/// Four significant digits, whatever the locale.
std::string short_text(double value) {
  std::array<char, 32> text;
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 4);
  return std::string(text.data(), end.ptr);
}

double quantile(const std::vector<double>& sorted, std::size_t percent) {
  return sorted[(sorted.size() - 1) * percent / 100];
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

std::vector<double> neighbor_distances(std::span<const SpacingSite> sites, std::size_t neighbors) {
  const std::vector<SpacingSite> distinct = distinct_sites(sites);
  std::vector<double> means = all_mean_distances(distinct, neighbors, true);
  if (means.empty()) means = all_mean_distances(distinct, neighbors, false);
  return means;
}

RadiiChoice choose_radii(std::span<const SpacingSite> sites, std::uint64_t points, int levels) {
  RadiiChoice choice;
  const std::vector<double> means = neighbor_distances(sites, kNeighbors);
  if (means.empty()) {
    choice.reason = points < 2 ? "there are fewer than two points"
                               : "no two different points were found near one another";
    return choice;
  }
  choice.spacing = quantile(means, 50);
  double ball_radius = kRadiusPerSpacing * (levels == 1 ? quantile(means, 90) : choice.spacing);
  for (int level = 0; level < levels; ++level) {
    choice.radii.push_back(ball_radius);
    ball_radius *= kRadiusGrowth;
  }
  choice.reason = reason_of(choice, means, points);
  return choice;
}

}  // namespace orbweave
