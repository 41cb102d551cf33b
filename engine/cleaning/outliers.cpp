#include "engine/cleaning/outliers.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>

#include "engine/normals/point_tree.h"
#include "io/box.h"

namespace orbweave {
namespace {

/// Fewer neighbours than that are no neighbourhood.
constexpr std::size_t kFewest = 3;
/// A deviation is at least this part of the mean: on a regular grid all distances are the same, and
/// the points of its border (whose mean distance is about 1.3 times that of the inner ones) would
/// lie any number of deviations off.
constexpr double kLeastDeviation = 0.15;
constexpr std::size_t kGrain = 512;

using Range = tbb::blocked_range<std::size_t>;

/// Nearest neighbours within the radius, without the point itself.
class Neighborhoods {
 public:
  Neighborhoods(std::span<const Vec3> positions, const OutlierOptions& options)
      : positions_(positions),
        options_(options),
        squared_radius_(options.max_radius * options.max_radius),
        tree_(positions) {}

  void around(std::size_t point, std::vector<Neighbor>& found) const {
    tree_.nearest(positions_[point], options_.neighbors + 1, found);
    std::erase_if(found, [&](const Neighbor& neighbor) {
      return neighbor.index == point || neighbor.squared_distance > squared_radius_;
    });
    if (found.size() > options_.neighbors) found.pop_back();
  }

  /// Neighbours that are missing are at least as far away as the radius.
  double mean_distance(const std::vector<Neighbor>& found) const {
    double sum = static_cast<double>(options_.neighbors - found.size()) * options_.max_radius;
    for (const Neighbor& neighbor : found) sum += std::sqrt(neighbor.squared_distance);
    return sum / static_cast<double>(options_.neighbors);
  }

 private:
  std::span<const Vec3> positions_;
  OutlierOptions options_;
  double squared_radius_;
  PointTree tree_;
};

/// Mean distances of all points that can be neighbours of points [begin, end); 0 elsewhere.
std::vector<double> mean_distances(std::span<const Vec3> positions, std::uint32_t begin,
                                   std::uint32_t end, const Neighborhoods& neighborhoods,
                                   double max_radius) {
  Box reach;
  for (const Vec3& p : positions.subspan(begin, end - begin)) reach.extend(p);
  reach = reach.grown(1.01 * max_radius);
  std::vector<double> means(positions.size(), 0.0);
  tbb::parallel_for(Range(0, positions.size(), kGrain), [&](const Range& range) {
    std::vector<Neighbor> found;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      if (!reach.contains(positions[i])) continue;
      neighborhoods.around(i, found);
      means[i] = neighborhoods.mean_distance(found);
    }
  });
  return means;
}

bool lies_alone(double own, const std::vector<Neighbor>& found, const std::vector<double>& means,
                double sigma) {
  if (found.size() < kFewest) return true;
  const auto count = static_cast<double>(found.size());
  double mean = 0.0, variance = 0.0;
  for (const Neighbor& neighbor : found) mean += means[neighbor.index] / count;
  for (const Neighbor& neighbor : found) {
    const double off = means[neighbor.index] - mean;
    variance += off * off / count;
  }
  return own > mean + sigma * std::max(std::sqrt(variance), kLeastDeviation * mean);
}

}  // namespace

double outlier_halo(const OutlierOptions& options) { return 2.0 * options.max_radius; }

std::vector<std::uint8_t> find_outliers(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const OutlierOptions& options) {
  std::vector<std::uint8_t> outliers(end - begin, 0);
  if (begin == end) return outliers;
  const Neighborhoods neighborhoods(positions, options);
  const std::vector<double> means =
      mean_distances(positions, begin, end, neighborhoods, options.max_radius);
  tbb::parallel_for(Range(begin, end, kGrain), [&](const Range& range) {
    std::vector<Neighbor> found;
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      neighborhoods.around(i, found);
      outliers[i - begin] = lies_alone(means[i], found, means, options.sigma) ? 1 : 0;
    }
  });
  return outliers;
}

}  // namespace orbweave
