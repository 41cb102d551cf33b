#include "engine/cleaning/clusters.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "engine/geometry/lattice_cube.h"

namespace orbweave {
namespace {

/// Longest extent of a small cluster, in cubes.
constexpr std::int64_t kMostCubes = 3;
/// The cubes of a small cluster, those around it, and what a point's place in its cube makes up.
constexpr double kCubesOfHalo = 5.0;
constexpr double kRounding = 1.01;

/// Occupied cubes, ascending, and how many points each holds.
class Cubes {
 public:
  Cubes(std::span<const Vec3> positions, const ClusterOptions& options) {
    // Points in canonical order have few runs.
    std::vector<std::pair<LatticeCell, std::uint64_t>> runs;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (i % kStopBlock == 0) check_stop(options.stop);
      const LatticeCell cube = cube_of(positions[i], options.gap);
      if (runs.empty() || runs.back().first != cube) runs.emplace_back(cube, 0);
      ++runs.back().second;
    }
    std::sort(runs.begin(), runs.end());
    for (const auto& [cube, count] : runs) {
      if (cells_.empty() || cells_.back() != cube) {
        cells_.push_back(cube);
        counts_.push_back(0);
      }
      counts_.back() += count;
    }
    parents_.resize(cells_.size());
    std::iota(parents_.begin(), parents_.end(), 0u);
    for (std::uint32_t cube = 0; cube < cells_.size(); ++cube) {
      if (cube % kStopBlock == 0) check_stop(options.stop);
      join_neighbors(cube);
    }
    sum_up();
  }

  /// Whether the component of a point's cube is small.
  bool is_small(const LatticeCell& cell, std::uint64_t points) const {
    const std::uint32_t root = parents_[index_of(cell)];
    const Sum& sum = sums_[root];
    const auto is_short = [](std::int64_t low, std::int64_t high) {
      return high - low < kMostCubes;
    };
    return sum.points < points && is_short(sum.low.x, sum.high.x) &&
           is_short(sum.low.y, sum.high.y) && is_short(sum.low.z, sum.high.z);
  }

 private:
  struct Sum {
    LatticeCell low, high;
    std::uint64_t points = 0;
  };

  std::size_t index_of(const LatticeCell& cell) const {
    return static_cast<std::size_t>(std::lower_bound(cells_.begin(), cells_.end(), cell) -
                                    cells_.begin());
  }

  std::uint32_t root_of(std::uint32_t cube) {
    while (parents_[cube] != cube) cube = parents_[cube] = parents_[parents_[cube]];
    return cube;
  }

  /// With those of the 13 cubes before it that are occupied.
  void join_neighbors(std::uint32_t cube) {
    const LatticeCell cell = cells_[cube];
    for (std::int64_t z = -1; z <= 0; ++z)
      for (std::int64_t y = -1; y <= (z < 0 ? 1 : 0); ++y) {
        const LatticeCell first{cell.z + z, cell.y + y, cell.x - 1};
        const LatticeCell last{cell.z + z, cell.y + y, cell.x + (z < 0 || y < 0 ? 1 : -1)};
        for (std::size_t other = index_of(first); other < cells_.size() && !(last < cells_[other]);
             ++other)
          parents_[root_of(static_cast<std::uint32_t>(other))] = root_of(cube);
      }
  }

  void sum_up() {
    sums_.resize(cells_.size());
    for (std::uint32_t cube = 0; cube < cells_.size(); ++cube) {
      const std::uint32_t root = parents_[cube] = root_of(cube);
      const LatticeCell cell = cells_[cube];
      Sum& sum = sums_[root];
      if (sum.points == 0) sum.low = sum.high = cell;
      sum.low = {std::min(sum.low.z, cell.z), std::min(sum.low.y, cell.y),
                 std::min(sum.low.x, cell.x)};
      sum.high = {std::max(sum.high.z, cell.z), std::max(sum.high.y, cell.y),
                  std::max(sum.high.x, cell.x)};
      sum.points += counts_[cube];
    }
  }

  std::vector<LatticeCell> cells_;
  std::vector<std::uint64_t> counts_;
  std::vector<std::uint32_t> parents_;
  std::vector<Sum> sums_;
};

}  // namespace

double cluster_halo(const ClusterOptions& options) {
  return kRounding * kCubesOfHalo * options.gap;
}

std::vector<std::uint8_t> find_clusters(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const ClusterOptions& options) {
  std::vector<std::uint8_t> found(end - begin, 0);
  if (begin == end) return found;
  const Cubes cubes(positions, options);
  LatticeCell last;
  bool is_small = false;
  for (std::uint32_t i = begin; i < end; ++i) {
    const LatticeCell cube = cube_of(positions[i], options.gap);
    if (i == begin || cube != last) is_small = cubes.is_small(cube, options.points);
    last = cube;
    found[i - begin] = is_small ? 1 : 0;
  }
  return found;
}

}  // namespace orbweave
