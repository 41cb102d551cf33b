// Principal components of the nearest neighbours: the direction in which they deviate least.
#include "engine/normals/estimate_normals.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/neighbor_search.h"
#include "engine/geometry/symmetric_eigen.h"
#include "io/error.h"

namespace orbweave {
namespace {

/// Variance across a row of points over that along it, below which the row tells no plane and
/// more neighbours are asked for: deviations of 1:10.
constexpr double kNearlyALine = 1e-2;
/// The limit where there are no more neighbours: a smaller deviation is noise.
constexpr double kALine = 1e-6;
/// A row that is nothing but a row at this many times the neighbours asked for stays one.
constexpr std::size_t kMostEnlarged = 16;

struct Plane {
  Vec3 normal;
  float roughness = 1.0f;
};

class Estimator {
 public:
  Estimator(std::span<const Vec3> positions, const NeighborSearch& search,
            const NormalEstimateOptions& options)
      : positions_(positions),
        search_(search),
        neighbors_(std::max<std::size_t>(options.neighbors, 3)),
        max_squared_(squared_reach(options.max_radius)) {}

  /// Points [begin, end) of one block.
  void block(std::uint32_t begin, std::uint32_t end, Plane* planes) {
    query_.find(search_, begin, end, neighbors_, max_squared_);
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::span<const Neighbor> found = query_.of(i);
      SymmetricEigen eigen = spread_of(i, found);
      if (found.size() == neighbors_ && nearly_a_line(eigen)) eigen = enlarged(i);
      planes[i - begin] = plane_of(eigen);
    }
  }

 private:
  static bool nearly_a_line(const SymmetricEigen& e) {
    return !(e.values[1] > kNearlyALine * e.values[2]);
  }

  static Plane plane_of(const SymmetricEigen& e) {
    if (!(e.values[1] > kALine * e.values[2])) return {};
    Vec3 n = e.vectors[0];
    int axis = 0;
    for (int other = 1; other < 3; ++other)
      if (std::abs(n[other]) > std::abs(n[axis])) axis = other;
    if (n[axis] < 0.0) n = -n;
    const double share = std::sqrt(std::clamp(e.values[0] / e.values[1], 0.0, 1.0));
    return {n, static_cast<float>(share)};
  }

  SymmetricEigen enlarged(std::uint32_t i) {
    for (std::size_t count = 2 * neighbors_;; count *= 2) {
      more_.find(search_, i, i + 1, count, max_squared_);
      const std::span<const Neighbor> found = more_.of(i);
      const SymmetricEigen eigen = spread_of(i, found);
      if (found.size() < count || count >= kMostEnlarged * neighbors_ || !nearly_a_line(eigen))
        return eigen;
    }
  }

  /// Of the point and its neighbours about their mean, summed nearest first.
  SymmetricEigen spread_of(std::uint32_t i, std::span<const Neighbor> found) {
    if (found.size() < 3) return {};
    differences_.clear();
    Vec3 mean;
    for (const Neighbor& n : found) {
      differences_.push_back(positions_[n.index] - positions_[i]);
      mean = mean + differences_.back();
    }
    mean = mean / static_cast<double>(found.size() + 1);
    SymmetricMatrix sum = outer(mean);
    for (const Vec3& d : differences_) sum += outer(d - mean);
    return eigen_of(sum);
  }

  std::span<const Vec3> positions_;
  const NeighborSearch& search_;
  std::size_t neighbors_;
  double max_squared_;
  NeighborSearch::Query query_, more_;
  std::vector<Vec3> differences_;
};

}  // namespace

EstimatedNormals estimate_normals(std::span<const Vec3> positions, std::uint32_t begin,
                                  std::uint32_t end, const NormalEstimateOptions& options) {
  EstimatedNormals result;
  result.normals.resize(end - begin);
  result.roughness.resize(end - begin);
  if (begin == end) return result;
  const NeighborSearch search(positions);
  constexpr std::uint32_t kBlock = NeighborSearch::kBlock;
  tbb::enumerable_thread_specific<Estimator> estimators(
      [&] { return Estimator(positions, search, options); });
  using Range = tbb::blocked_range<std::uint32_t>;
  tbb::parallel_for(Range(begin / kBlock, (end - 1) / kBlock + 1, 64), [&](const Range& range) {
    Estimator& estimator = estimators.local();
    Plane planes[kBlock];
    for (std::uint32_t block = range.begin(); block < range.end(); ++block) {
      if (block % (kStopBlock / kBlock) == 0) check_stop(options.stop);
      const std::uint32_t first = std::max(begin, block * kBlock);
      const std::uint32_t last =
          static_cast<std::uint32_t>(std::min<std::uint64_t>(end, (block + 1ull) * kBlock));
      estimator.block(first, last, planes);
      for (std::uint32_t i = first; i < last; ++i) {
        result.normals[i - begin] = planes[i - first].normal;
        result.roughness[i - begin] = planes[i - first].roughness;
      }
    }
  });
  return result;
}

}  // namespace orbweave
