#include "engine/cleaning/outliers.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "engine/geometry/neighbor_search.h"

namespace orbweave {
namespace {

/// Fewer neighbours than that are no neighbourhood.
constexpr std::size_t kFewest = 3;
/// A deviation is at least this part of the mean: on a regular grid all distances are the same, and
/// the points of its border (whose mean distance is about 1.3 times that of the inner ones) would
/// lie any number of deviations off.
constexpr double kLeastDeviation = 0.15;
constexpr std::size_t kGrain = 32;  // blocks

/// Mean distances of all points to their neighbours, and who these are for points [begin, end).
class Neighborhoods {
 public:
  Neighborhoods(std::span<const Vec3> positions, std::uint32_t begin, std::uint32_t end,
                const OutlierOptions& options)
      : begin_(begin),
        end_(end),
        options_(options),
        row_(std::min(options.neighbors, positions.size())),
        means_(positions.size()),
        counts_(end - begin),
        neighbors_(std::make_unique_for_overwrite<std::uint32_t[]>((end - begin) * row_)) {
    const NeighborSearch search(positions);
    const std::uint32_t blocks = (search.size() - 1) / NeighborSearch::kBlock + 1;
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, blocks, kGrain), [&](const auto& range) {
      NeighborSearch::Query query;
      for (std::uint32_t block = range.begin(); block < range.end(); ++block)
        measure_block(search, block, query);
    });
  }

  /// Whether a point of [begin, end) is an outlier.
  bool lies_alone(std::uint32_t point) const {
    const std::span<const std::uint32_t> found = neighbors(point);
    if (found.size() < kFewest) return true;
    const auto count = static_cast<double>(found.size());
    double sum = 0.0, squares = 0.0;
    for (const std::uint32_t neighbor : found) sum += means_[neighbor];
    const double mean = sum / count;
    const double least = kLeastDeviation * mean;
    // Nearly all points are not even that far off.
    if (!(means_[point] > mean + options_.sigma * least)) return false;
    for (const std::uint32_t neighbor : found) {
      const double off = means_[neighbor] - mean;
      squares += off * off;
    }
    return means_[point] > mean + options_.sigma * std::max(std::sqrt(squares / count), least);
  }

 private:
  void measure_block(const NeighborSearch& search, std::uint32_t block,
                     NeighborSearch::Query& query) {
    if (block % (kStopBlock / NeighborSearch::kBlock) == 0) check_stop(options_.stop);
    const std::uint32_t first = block * NeighborSearch::kBlock;
    const std::uint32_t last = first + std::min(NeighborSearch::kBlock, search.size() - first);
    query.find(search, first, last, options_.neighbors, squared_reach(options_.max_radius));
    for (std::uint32_t i = first; i < last; ++i) {
      means_[i] = mean_distance(query.squared_of(i));
      if (i < begin_ || i >= end_) continue;
      const std::span<const std::uint32_t> found = query.of(i);
      counts_[i - begin_] = static_cast<std::uint32_t>(found.size());
      std::copy(found.begin(), found.end(), row_of(i));
    }
  }

  /// Neighbours that are missing are at least as far away as the radius.
  double mean_distance(std::span<const double> squared) const {
    double sum = static_cast<double>(options_.neighbors - squared.size()) * options_.max_radius;
    for (const double one : squared) sum += std::sqrt(one);
    return sum / static_cast<double>(options_.neighbors);
  }

  std::uint32_t* row_of(std::uint32_t point) const {
    return neighbors_.get() + std::size_t{point - begin_} * row_;
  }
  std::span<const std::uint32_t> neighbors(std::uint32_t point) const {
    return {row_of(point), counts_[point - begin_]};
  }

  std::uint32_t begin_, end_;
  OutlierOptions options_;
  std::size_t row_;
  std::vector<double> means_;
  std::vector<std::uint32_t> counts_;
  std::unique_ptr<std::uint32_t[]> neighbors_;  // rows, of which each thread writes its own first
};

}  // namespace

double outlier_halo(const OutlierOptions& options) { return 2.0 * options.max_radius; }

std::vector<std::uint8_t> find_outliers(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const OutlierOptions& options) {
  std::vector<std::uint8_t> outliers(end - begin, 0);
  if (begin == end) return outliers;
  const Neighborhoods neighborhoods(positions, begin, end, options);
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(begin, end, 4096), [&](const auto& range) {
    for (std::uint32_t i = range.begin(); i < range.end(); ++i)
      outliers[i - begin] = neighborhoods.lies_alone(i) ? 1 : 0;
  });
  return outliers;
}

}  // namespace orbweave
