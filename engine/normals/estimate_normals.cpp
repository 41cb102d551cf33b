// Principal components of the nearest neighbours: the direction in which they deviate least.
#include "engine/normals/estimate_normals.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/geometry/local_surface.h"
#include "engine/geometry/neighbor_grid.h"
#include "engine/geometry/neighbor_search.h"
#include "engine/geometry/symmetric_eigen.h"
#include "engine/normals/point_row.h"
#include "io/error.h"

namespace orbweave {
namespace {

/// As kNearlyALine where there are no more neighbours: a smaller deviation is noise.
constexpr double kALine = 1e-6;

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

  /// Those points of [begin, end), which lie in one block, that are asked for.
  void block(std::uint32_t begin, std::uint32_t end, std::span<const std::uint8_t> asked,
             EstimatedNormals& result) {
    while (begin < end && asked[begin] == 0) ++begin;
    while (begin < end && asked[end - 1] == 0) --end;
    if (begin == end) return;
    query_.find(search_, begin, end, neighbors_, max_squared_, asked.subspan(begin, end - begin));
    constexpr std::size_t kAtOnce = 4;
    for (std::uint32_t next = begin; next < end;) {
      std::array<std::uint32_t, kAtOnce> points{};
      std::array<SymmetricMatrix, kAtOnce> spreads{};
      std::size_t count = 0;
      for (; next < end && count < kAtOnce; ++next) {
        if (asked[next] == 0) continue;
        points[count] = next;
        spreads[count++] = spread_of(next, query_.of(next));
      }
      const std::array<SymmetricEigen, kAtOnce> eigen = eigen_of_four(spreads);
      for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t i = points[k];
        const bool more = query_.of(i).size() == neighbors_ && nearly_a_line(eigen[k]);
        const Plane plane = plane_of(more ? enlarged(i) : eigen[k]);
        result.normals[i] = plane.normal;
        result.roughness[i] = plane.roughness;
      }
    }
  }

 private:
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

/// The planes of all points that are asked for.
void estimate_asked(std::span<const Vec3> positions, const NeighborSearch& search,
                    const NormalEstimateOptions& options, std::span<const std::uint8_t> asked,
                    EstimatedNormals& result) {
  constexpr std::uint32_t kBlock = NeighborSearch::kBlock;
  tbb::enumerable_thread_specific<Estimator> estimators(
      [&] { return Estimator(positions, search, options); });
  using Range = tbb::blocked_range<std::uint32_t>;
  const std::uint32_t blocks = (search.size() - 1) / kBlock + 1;
  tbb::parallel_for(Range(0, blocks, 64), [&](const Range& range) {
    Estimator& estimator = estimators.local();
    for (std::uint32_t block = range.begin(); block < range.end(); ++block) {
      if (block % (kStopBlock / kBlock) == 0) check_stop(options.stop);
      const std::uint32_t first = block * kBlock;
      estimator.block(first, first + std::min(kBlock, search.size() - first), asked, result);
    }
  });
}

std::uint32_t nearest_to_middle(std::span<const Vec3> positions,
                                std::span<const std::uint32_t> points) {
  const Vec3 first = positions[points.front()];
  Vec3 sum;
  for (const std::uint32_t point : points) sum = sum + (positions[point] - first);
  const Vec3 middle = first + sum / static_cast<double>(points.size());
  const auto is_nearer = [&](std::uint32_t a, std::uint32_t b) {
    return squared_norm(positions[a] - middle) < squared_norm(positions[b] - middle);
  };
  return *std::min_element(points.begin(), points.end(), is_nearer);
}

/// The point whose normal each of [begin, end) is to have.
std::vector<std::uint32_t> representatives(std::span<const Vec3> positions, std::uint32_t begin,
                                           std::uint32_t end, double side) {
  const NeighborGrid grid(positions, NeighborGrid::radius_of_side(side));
  std::vector<std::uint32_t> of_point(end - begin);
  tbb::parallel_for(std::uint32_t{0}, grid.cells(), [&](std::uint32_t cell) {
    const auto members = grid.members(cell);
    const auto first = std::lower_bound(members.begin(), members.end(), begin);
    const auto last = std::lower_bound(first, members.end(), end);
    if (first == last) return;
    const std::uint32_t representative = nearest_to_middle(positions, members);
    for (auto it = first; it != last; ++it) of_point[*it - begin] = representative;
  });
  return of_point;
}

/// Those of the points [begin, end).
EstimatedNormals rows_of(EstimatedNormals all, std::uint32_t begin, std::uint32_t end) {
  const auto keep = [&](auto& values) {
    values.resize(end);
    values.erase(values.begin(), values.begin() + begin);
  };
  keep(all.normals);
  keep(all.roughness);
  return all;
}

}  // namespace

double normal_halo(const NormalEstimateOptions& options) {
  // A point's representative lies in its cube, and so does all that chooses it.
  return options.max_radius + std::numbers::sqrt3 * options.shared_side;
}

EstimatedNormals estimate_normals(std::span<const Vec3> positions, std::uint32_t begin,
                                  std::uint32_t end, const NormalEstimateOptions& options,
                                  std::span<const std::uint8_t> chosen) {
  EstimatedNormals result;
  if (begin == end) return result;
  const NeighborSearch search(positions);
  EstimatedNormals all{std::vector<Vec3>(positions.size()),
                       std::vector<float>(positions.size(), 1.0f)};
  std::vector<std::uint8_t> asked(positions.size(), 0);
  const auto is_chosen = [&](std::uint32_t i) { return chosen.empty() || chosen[i - begin] != 0; };
  if (!(options.shared_side > 0.0)) {
    for (std::uint32_t i = begin; i < end; ++i) asked[i] = is_chosen(i) ? 1 : 0;
    estimate_asked(positions, search, options, asked, all);
    return rows_of(std::move(all), begin, end);
  }
  std::vector<std::uint32_t> source = representatives(positions, begin, end, options.shared_side);
  for (std::uint32_t i = begin; i < end; ++i)
    if (is_chosen(i)) asked[source[i - begin]] = 1;
  estimate_asked(positions, search, options, asked, all);
  std::fill(asked.begin(), asked.end(), 0);
  for (std::uint32_t i = begin; i < end; ++i)
    if (all.normals[source[i - begin]] == Vec3{}) source[i - begin] = i;
  for (std::uint32_t i = begin; i < end; ++i)
    asked[i] = is_chosen(i) && source[i - begin] == i && all.normals[i] == Vec3{} ? 1 : 0;
  estimate_asked(positions, search, options, asked, all);
  result.normals.reserve(source.size());
  result.roughness.reserve(source.size());
  for (std::uint32_t i = begin; i < end; ++i) {
    const std::uint32_t point = source[i - begin];
    result.normals.push_back(is_chosen(i) ? all.normals[point] : Vec3{});
    result.roughness.push_back(is_chosen(i) ? all.roughness[point] : 1.0F);
  }
  return result;
}

}  // namespace orbweave
