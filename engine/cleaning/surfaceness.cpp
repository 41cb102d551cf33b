#include "engine/cleaning/surfaceness.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/neighbor_search.h"
#include "engine/geometry/symmetric_eigen.h"

namespace orbweave {
namespace {

constexpr std::size_t kFewest = 3;
constexpr std::size_t kGrain = 32;  // blocks

/// Of the point and its neighbours about their mean.
SymmetricMatrix spread_of(std::span<const Vec3> positions, std::uint32_t point,
                          std::span<const std::uint32_t> neighbors) {
  const Vec3 origin = positions[point];
  Vec3 mean;
  for (const std::uint32_t i : neighbors) mean = mean + (positions[i] - origin);
  mean = mean / static_cast<double>(neighbors.size() + 1);
  SymmetricMatrix m{};
  const auto add = [&m](Vec3 d) {
    m.xx += d.x * d.x;
    m.xy += d.x * d.y;
    m.xz += d.x * d.z;
    m.yy += d.y * d.y;
    m.yz += d.y * d.z;
    m.zz += d.z * d.z;
  };
  add(-mean);
  for (const std::uint32_t i : neighbors) add(positions[i] - origin - mean);
  return m;
}

float surfaceness(const SymmetricEigen& eigen) {
  const auto deviation = [&](std::size_t k) { return std::sqrt(std::max(0.0, eigen.values[k])); };
  const double longest = deviation(2);
  return longest > 0.0 ? static_cast<float>((deviation(1) - deviation(0)) / longest) : 1.0F;
}

}  // namespace

std::vector<float> surfaceness_of(std::span<const Vec3> positions, std::uint32_t begin,
                                  std::uint32_t end, const SurfacenessOptions& options) {
  std::vector<float> result(end - begin, 1.0F);
  if (begin == end) return result;
  const NeighborSearch search(positions);
  constexpr std::uint32_t kBlock = NeighborSearch::kBlock;
  using Range = tbb::blocked_range<std::uint32_t>;
  tbb::parallel_for(Range(begin / kBlock, (end - 1) / kBlock + 1, kGrain), [&](const Range& range) {
    NeighborSearch::Query query;
    for (std::uint32_t block = range.begin(); block < range.end(); ++block) {
      if (block % (kStopBlock / kBlock) == 0) check_stop(options.stop);
      const std::uint32_t first = std::max(begin, block * kBlock);
      const std::uint32_t last = std::min(end, (block + 1) * kBlock);
      query.find(search, first, last, options.neighbors, squared_reach(options.max_radius));
      for (std::uint32_t i = first; i < last; ++i)
        if (query.of(i).size() >= kFewest)
          result[i - begin] = surfaceness(eigen_of(spread_of(positions, i, query.of(i))));
    }
  });
  return result;
}

}  // namespace orbweave
