#include "engine/cleaning/outliers.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/normals/neighbor_search.h"

namespace orbweave {
namespace {

/// Fewer neighbours than that are no neighbourhood.
constexpr std::size_t kFewest = 3;
/// A deviation is at least this part of the mean: on a regular grid all distances are the same, and
/// the points of its border (whose mean distance is about 1.3 times that of the inner ones) would
/// lie any number of deviations off.
constexpr double kLeastDeviation = 0.15;
constexpr std::size_t kGrain = 32;  // blocks

/// Calls visit(i, neighbours) for points [begin, end); neighbours come by distance.
template <class Visit>
void for_neighborhoods(const NeighborSearch& search, std::uint32_t begin, std::uint32_t end,
                       const OutlierOptions& options, const Visit& visit) {
  constexpr std::uint32_t kBlock = NeighborSearch::kBlock;
  const double max_squared = squared_reach(options.max_radius);
  tbb::parallel_for(
      tbb::blocked_range<std::uint32_t>(begin / kBlock, (end - 1) / kBlock + 1, kGrain),
      [&](const auto& range) {
        NeighborSearch::Query query;
        for (std::uint64_t block = range.begin(); block < range.end(); ++block) {
          const auto first =
              static_cast<std::uint32_t>(std::max<std::uint64_t>(begin, block * kBlock));
          const auto last =
              static_cast<std::uint32_t>(std::min<std::uint64_t>(end, (block + 1) * kBlock));
          query.find(search, first, last, options.neighbors, max_squared);
          for (std::uint32_t i = first; i < last; ++i) visit(i, query.of(i));
        }
      });
}

/// Neighbours that are missing are at least as far away as the radius.
double mean_distance(std::span<const Neighbor> found, const OutlierOptions& options) {
  double sum = static_cast<double>(options.neighbors - found.size()) * options.max_radius;
  for (const Neighbor& neighbor : found) sum += std::sqrt(neighbor.squared_distance);
  return sum / static_cast<double>(options.neighbors);
}

bool lies_alone(double own, std::span<const Neighbor> found, const std::vector<double>& means,
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
  const NeighborSearch search(positions);
  std::vector<double> means(positions.size());
  const auto all = static_cast<std::uint32_t>(positions.size());
  for_neighborhoods(search, 0, all, options, [&](std::uint32_t i, std::span<const Neighbor> found) {
    means[i] = mean_distance(found, options);
  });
  for_neighborhoods(search, begin, end, options,
                    [&](std::uint32_t i, std::span<const Neighbor> found) {
                      outliers[i - begin] = lies_alone(means[i], found, means, options.sigma);
                    });
  return outliers;
}

}  // namespace orbweave
