#include "engine/cleaning/clusters.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "engine/geometry/cell_rows.h"
#include "engine/geometry/lattice_cube.h"
#include "engine/geometry/neighbor_grid.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Longest extent of a small cluster, in cubes.
constexpr std::int64_t kMostCubes = 3;
/// The cubes of a small cluster, those around it, and what a point's place in its cube makes up.
constexpr double kCubesOfHalo = 5.0;
constexpr double kRounding = 1.01;

/// Points that follow each other in one cube: canonical order has few such runs.
struct Runs {
  std::vector<LatticeCell> cubes;
  std::vector<std::uint32_t> begins;  ///< of the runs, and the number of points
};

Runs runs_of(std::span<const Vec3> positions, const ClusterOptions& options) {
  const double per_unit = 1.0 / options.gap;
  Runs runs;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    if (i % kStopBlock == 0) check_stop(options.stop);
    const Vec3 p = per_unit * positions[i];
    const LatticeCell cube{whole_below(p.z), whole_below(p.y), whole_below(p.x)};
    if (!runs.cubes.empty() && runs.cubes.back() == cube) continue;
    runs.cubes.push_back(cube);
    runs.begins.push_back(i);
  }
  runs.begins.push_back(static_cast<std::uint32_t>(positions.size()));
  return runs;
}

/// Components of occupied cubes that touch.
class Components {
 public:
  Components(const Runs& runs, const ClusterOptions& options)
      : runs_(runs), cubes_(runs.cubes), parents_(cubes_.cells()) {
    std::iota(parents_.begin(), parents_.end(), 0u);
    const CellRows rows(cubes_);
    check_loops_are_whole();
    for (std::uint32_t cube = 0; cube < cubes_.cells(); ++cube) {
      if (cube % kStopBlock == 0) check_stop(options.stop);
      rows.for_each_around(cube, [&](std::uint32_t other) {
        if (other < cube) parents_[root_of(other)] = root_of(cube);
      });
    }
    sum_up();
  }

  /// Calls visit(first point, last point and one) for the runs of all components that are small.
  template <class Visit>
  void for_small(std::uint64_t points, const Visit& visit) const {
    for (std::uint32_t cube = 0; cube < cubes_.cells(); ++cube) {
      if (!sums_[parents_[cube]].is_small(points)) continue;
      for (const std::uint32_t run : cubes_.members(cube))
        visit(runs_.begins[run], runs_.begins[run + 1]);
    }
  }

 private:
  struct Sum {
    LatticeBox box;
    std::uint64_t points = 0;

    bool is_small(std::uint64_t most_points) const {
      const auto is_short = [](std::int64_t low, std::int64_t high) {
        return high - low < kMostCubes;
      };
      return points < most_points && is_short(box.low.x, box.high.x) &&
             is_short(box.low.y, box.high.y) && is_short(box.low.z, box.high.z);
    }
  };

  std::uint32_t root_of(std::uint32_t cube) {
    while (parents_[cube] != cube) cube = parents_[cube] = parents_[parents_[cube]];
    return cube;
  }

  void sum_up() {
    sums_.resize(cubes_.cells());
    for (std::uint32_t cube = 0; cube < cubes_.cells(); ++cube) {
      const std::uint32_t root = parents_[cube] = root_of(cube);
      const LatticeCell cell = cubes_.lattice_cell(cube);
      Sum& sum = sums_[root];
      if (sum.points == 0) sum.box = {cell, cell};
      sum.box.extend(cell);
      for (const std::uint32_t run : cubes_.members(cube))
        sum.points += runs_.begins[run + 1] - runs_.begins[run];
    }
  }

  const Runs& runs_;
  NeighborGrid cubes_;  ///< of the runs
  std::vector<std::uint32_t> parents_;
  std::vector<Sum> sums_;  ///< of roots
};

}  // namespace

double cluster_halo(const ClusterOptions& options) {
  return kRounding * kCubesOfHalo * options.gap;
}

std::vector<std::uint8_t> find_clusters(std::span<const Vec3> positions, std::uint32_t begin,
                                        std::uint32_t end, const ClusterOptions& options) {
  std::vector<std::uint8_t> found(end - begin, 0);
  if (begin == end) return found;
  const Runs runs = runs_of(positions, options);
  Components(runs, options).for_small(options.points, [&](std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t i = std::max(begin, first); i < std::min(end, last); ++i)
      found[i - begin] = 1;
  });
  return found;
}

}  // namespace orbweave
