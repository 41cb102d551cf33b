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

/// Points of one cube that follow each other.
struct Run {
  LatticeCell cube;
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
};

/// Points in canonical order have few runs.
std::vector<Run> runs_of(std::span<const Vec3> positions, const ClusterOptions& options) {
  const double per_unit = 1.0 / options.gap;
  std::vector<Run> runs;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    if (i % kStopBlock == 0) check_stop(options.stop);
    const Vec3 p = per_unit * positions[i];
    const LatticeCell cube{whole_below(p.z), whole_below(p.y), whole_below(p.x)};
    if (runs.empty() || runs.back().cube != cube) runs.push_back({cube, i, i});
    ++runs.back().end;
  }
  return runs;
}

/// Occupied cubes, ascending, and how many points each holds.
class Cubes {
 public:
  Cubes(std::span<const Run> runs_of_points, const ClusterOptions& options) {
    std::vector<std::pair<LatticeCell, std::uint64_t>> runs;
    runs.reserve(runs_of_points.size());
    for (const Run& run : runs_of_points) runs.emplace_back(run.cube, run.end - run.begin);
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
  const std::vector<Run> runs = runs_of(positions, options);
  const Cubes cubes(runs, options);
  for (const Run& run : runs)
    if (run.end > begin && run.begin < end && cubes.is_small(run.cube, options.points))
      for (std::uint32_t i = std::max(begin, run.begin); i < std::min(end, run.end); ++i)
        found[i - begin] = 1;
  return found;
}

}  // namespace orbweave
