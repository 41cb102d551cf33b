#include "engine/spacing/normal_radius.h"

#include <algorithm>
#include <vector>

#include "engine/spacing/automatic_radii.h"

namespace orbweave {

/// The neighbours for a normal: half as far again as they are where points are sparse. (The mean
/// distance to the k nearest of a disc's points is two thirds of that to the farthest.)
double normal_radius(const SampledNeighbors& sample, std::size_t neighbors, const StopToken* stop) {
  constexpr double kFarthestPerMean = 1.5;
  constexpr double kMargin = 1.5;
  constexpr double kMostPerMedian = 16.0;
  const std::vector<double> means = neighbor_distances(sample, neighbors, stop);
  if (means.empty()) return 0.0;
  const double median = means[means.size() / 2];
  const double sparse = means[(means.size() - 1) * 99 / 100];
  return kFarthestPerMean * kMargin * std::min(sparse, kMostPerMedian * median);
}

double normal_radius(const SearchedSites& sites, const SampledNeighbors& sample,
                     std::size_t neighbors, const StopToken* stop) {
  if (neighbors <= sample.neighbors()) return normal_radius(sample, neighbors, stop);
  constexpr std::uint64_t kPlaces = 4096;  // many neighbours of many places would fill the memory
  return normal_radius(SampledNeighbors(sites, neighbors, stop, kPlaces), neighbors, stop);
}

}  // namespace orbweave
