// Principal components of the nearest neighbours: the direction in which they deviate least.
#include "engine/normals/estimate_normals.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/geometry/local_surface.h"
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
    constexpr std::uint32_t kAtOnce = 4;
    for (std::uint32_t first = begin; first < end; first += kAtOnce) {
      const std::uint32_t last = std::min(first + kAtOnce, end);
      std::array<SymmetricMatrix, kAtOnce> spreads{};
      for (std::uint32_t i = first; i < last; ++i) spreads[i - first] = spread_of(i, query_.of(i));
      const std::array<SymmetricEigen, kAtOnce> eigen = eigen_of_four(spreads);
      for (std::uint32_t i = first; i < last; ++i) {
        const SymmetricEigen& of_point = eigen[i - first];
        const bool more = query_.of(i).size() == neighbors_ && nearly_a_line(of_point);
        planes[i - begin] = plane_of(more ? enlarged(i) : of_point);
      }
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
      const std::span<const std::uint32_t> found = more_.of(i);
      const SymmetricEigen eigen = eigen_of(spread_of(i, found));
      if (found.size() < count || count >= kMostEnlarged * neighbors_ || !nearly_a_line(eigen))
        return eigen;
    }
  }

  /// Of the point and its neighbours about their mean.
  SymmetricMatrix spread_of(std::uint32_t i, std::span<const std::uint32_t> found) {
    if (found.size() < 3) return {};
    differences_.reserve(found.size() + 1);
    NearColumns& d = differences_.columns;
    const Vec3 p = positions_[i];
    // The point itself is the first.
    std::uint32_t row = 1;
    for (const std::uint32_t n : found) {
      const Vec3 difference = positions_[n] - p;
      d.points.x[row] = difference.x;
      d.points.y[row] = difference.y;
      d.points.z[row++] = difference.z;
    }
    weigh_alike(row);
    SpreadSums sums;
    surface_kernel().spread(d, sums);
    const auto& m = sums.products;
    return {m[0], m[1], m[2], m[3], m[4], m[5]};
  }

  /// Rows that are beyond the next multiple of four are not looked at.
  void weigh_alike(std::uint32_t rows) {
    NearColumns& d = differences_.columns;
    std::fill_n(d.weight, rows, 1.0);
    for (double* column : {d.points.x, d.points.y, d.points.z, d.weight})
      std::fill_n(column + rows, (4 - rows % 4) % 4, 0.0);
    d.count = rows;
  }

  std::span<const Vec3> positions_;
  const NeighborSearch& search_;
  std::size_t neighbors_;
  double max_squared_;
  NeighborSearch::Query query_, more_;
  NearPoints differences_;
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
