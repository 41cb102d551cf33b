#include "engine/cleaning/thinning.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "engine/geometry/cell_rows.h"
#include "engine/geometry/neighbor_grid.h"

namespace orbweave {
namespace {

/// Cells of one colour are a cell apart and can be decided at the same time. The colour is made of
/// the parities of the cell's numbers (x the lowest bit), and colours are decided in the order of a
/// Gray code: x changes parity at most four times on the way, so that a decision depends on cells
/// that are at most four away.
constexpr std::array<int, 8> kOrderOfColors = {0, 1, 3, 2, 6, 7, 5, 4};
constexpr double kCellsOfHalo = 5.0;
/// Cells, and points of one cell, between two looks at the request to stop. A cell of points that
/// all lie on sheets of their own takes long.
constexpr std::size_t kLookEvery = 512;

int color_of(const LatticeCell& cell) {
  return static_cast<int>((cell.x & 1) | ((cell.y & 1) << 1) | ((cell.z & 1) << 2));
}

/// Rank within a cell, from signs and mantissas: a cloud scaled by a power of two keeps its ranks.
std::uint64_t rank_of(Vec3 p) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto bits = std::bit_cast<std::uint64_t>(p[axis] == 0.0 ? 0.0 : p[axis]);
    hash = (hash ^ (bits & 0x800FFFFFFFFFFFFFu)) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 32;
    hash *= 0xBF58476D1CE4E5B9u;
    hash ^= hash >> 29;
  }
  return hash;
}

/// The points and when two of them are so close that one of them is enough.
struct Cloud {
  std::span<const Vec3> positions;
  std::span<const Vec3> normals;
  double squared_spacing;
  double min_cosine;
  const StopToken* stop;

  Cloud(std::span<const Vec3> all_positions, std::span<const Vec3> all_normals,
        const ThinningOptions& options)
      : positions(all_positions),
        normals(options.min_cosine > -1.0 ? all_normals : std::span<const Vec3>()),
        squared_spacing(options.spacing * options.spacing),
        min_cosine(options.min_cosine),
        stop(options.stop) {}
  bool same_sheet(std::uint32_t a, std::uint32_t b) const {
    if (normals.empty()) return true;
    // Normals of files are not always of unit length.
    const double lengths = std::sqrt(squared_norm(normals[a]) * squared_norm(normals[b]));
    return lengths > 0.0 && dot(normals[a], normals[b]) >= min_cosine * lengths;
  }
  double squared_distance(std::uint32_t a, std::uint32_t b) const {
    return squared_norm(positions[a] - positions[b]);
  }
  bool replaces(std::uint32_t a, std::uint32_t b) const {
    return squared_distance(a, b) < squared_spacing && same_sheet(a, b);
  }
};

/// Points of a cell, with their ranks, in the order in which they are decided.
using RankedPoints = std::vector<std::pair<std::uint64_t, std::uint32_t>>;

void rank(std::span<const std::uint32_t> members, std::span<const Vec3> positions,
          RankedPoints& order) {
  order.clear();
  for (const std::uint32_t i : members) order.emplace_back(rank_of(positions[i]), i);
  std::sort(order.begin(), order.end());
}

/// The kept points of every cell, which has room for all of its own.
class KeptPoints {
 public:
  KeptPoints(const NeighborGrid& grid, std::size_t points)
      : grid_(&grid), points_(points), counts_(grid.cells(), 0) {}
  void add(std::uint32_t cell, std::uint32_t point) {
    points_[grid_->begin(cell) + counts_[cell]++] = point;
  }
  std::span<const std::uint32_t> of(std::uint32_t cell) const {
    return std::span(points_).subspan(grid_->begin(cell), counts_[cell]);
  }

 private:
  const NeighborGrid* grid_;
  std::vector<std::uint32_t> points_, counts_;
};

/// Decides cell after cell; the kept points become more as it goes.
class Thinning {
 public:
  Thinning(const Cloud& cloud, const NeighborGrid& grid, const CellRows& rows,
           std::span<const std::uint8_t> states = {})
      : cloud_(cloud),
        grid_(grid),
        rows_(rows),
        states_(states),
        kept_(grid, cloud.positions.size()) {}

  KeptPoints run() {
    for (std::uint32_t cell = 0; cell < grid_.cells() && !states_.empty(); ++cell)
      for (const std::uint32_t point : grid_.members(cell))
        if (states_[point] == 1) kept_.add(cell, point);
    std::array<std::vector<std::uint32_t>, 8> of_color;
    for (std::uint32_t cell = 0; cell < grid_.cells(); ++cell)
      of_color[color_of(grid_.lattice_cell(cell))].push_back(cell);
    for (const int color : kOrderOfColors) {
      const std::vector<std::uint32_t>& cells = of_color[color];
      tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size()), [&](const auto& range) {
        Scratch scratch;
        for (std::size_t i = range.begin(); i < range.end(); ++i) decide(cells[i], scratch);
      });
    }
    return std::move(kept_);
  }

 private:
  /// What a thread needs to decide cell after cell.
  struct Scratch {
    std::vector<std::uint32_t> rivals;
    RankedPoints ranked;
  };

  bool is_decided(std::uint32_t point) const { return !states_.empty() && states_[point] != 0; }

  /// Cells of the same colour are not among those around a cell, and those of later colours have
  /// kept nothing yet but what was given.
  void decide(std::uint32_t cell, Scratch& scratch) {
    std::vector<std::uint32_t>& rivals = scratch.rivals;
    rivals.clear();
    rows_.for_each_around(cell, [&](std::uint32_t near) {
      const auto kept = kept_.of(near);
      rivals.insert(rivals.end(), kept.begin(), kept.end());
    });
    std::size_t decided = cell;  // looks of small cells are spread
    rank(grid_.members(cell), cloud_.positions, scratch.ranked);
    for (const auto& ranked_point : scratch.ranked) {
      if (decided++ % kLookEvery == 0) check_stop(cloud_.stop);
      const std::uint32_t point = ranked_point.second;
      if (is_decided(point)) continue;
      const auto is_near = [&](std::uint32_t rival) { return cloud_.replaces(point, rival); };
      if (std::any_of(rivals.begin(), rivals.end(), is_near)) continue;
      rivals.push_back(point);
      kept_.add(cell, point);
    }
  }

  const Cloud& cloud_;
  const NeighborGrid& grid_;
  const CellRows& rows_;
  std::span<const std::uint8_t> states_;
  KeptPoints kept_;
};

/// The nearest kept point that replaces a point (of equally near ones the first); the point itself
/// where it is kept.
/// `near`: the kept points around its cell.
std::uint32_t representative(std::uint32_t point, std::span<const std::uint32_t> near,
                             const Cloud& cloud) {
  auto best = std::tuple(std::numeric_limits<double>::infinity(), point);
  for (const std::uint32_t kept : near) {
    if (kept == point) return point;
    if (cloud.replaces(point, kept))
      best = std::min(best, std::tuple(cloud.squared_distance(point, kept), kept));
  }
  return std::get<1>(best);
}

/// Pairs (kept point, point that it stands for), sorted.
std::vector<std::pair<std::uint32_t, std::uint32_t>> groups_of(const Cloud& cloud,
                                                               const NeighborGrid& grid,
                                                               const CellRows& rows,
                                                               const KeptPoints& kept) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> groups(cloud.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, grid.cells()), [&](const auto& range) {
    std::vector<std::uint32_t> near;
    for (std::uint32_t cell = range.begin(); cell < range.end(); ++cell) {
      near.clear();
      rows.for_each_around(cell, [&](std::uint32_t other) {
        near.insert(near.end(), kept.of(other).begin(), kept.of(other).end());
      });
      std::size_t grouped = cell;
      for (const std::uint32_t point : grid.members(cell)) {
        if (grouped++ % kLookEvery == 0) check_stop(cloud.stop);
        groups[point] = {representative(point, near, cloud), point};
      }
    }
  });
  std::sort(groups.begin(), groups.end());
  return groups;
}

std::vector<std::uint8_t> flags_of(const KeptPoints& kept, const NeighborGrid& grid,
                                   std::uint32_t begin, std::uint32_t end) {
  std::vector<std::uint8_t> flags(end - begin, 0);
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell) {
    for (const std::uint32_t point : kept.of(cell))
      if (point >= begin && point < end) flags[point - begin] = 1;
  }
  return flags;
}

}  // namespace

double thinning_halo(const ThinningOptions& options) {
  return kCellsOfHalo * NeighborGrid::cell_side(options.spacing);
}

std::vector<std::uint8_t> thin_points(std::span<const Vec3> positions,
                                      std::span<const Vec3> normals, std::uint32_t begin,
                                      std::uint32_t end, const ThinningOptions& options,
                                      std::span<const std::uint8_t> states) {
  const Cloud cloud(positions, normals, options);
  const NeighborGrid grid(positions, options.spacing);
  const CellRows rows(grid);
  return flags_of(Thinning(cloud, grid, rows, states).run(), grid, begin, end);
}

double merging_halo(const ThinningOptions& options) {
  // Points up to a spacing away join a kept one, unless another kept one, up to a spacing from
  // them, is nearer.
  return thinning_halo(options) + 2.0 * options.spacing;
}

MergedPoints merge_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                          std::uint32_t begin, std::uint32_t end, const ThinningOptions& options) {
  const Cloud cloud(positions, normals, options);
  const NeighborGrid grid(positions, options.spacing);
  const CellRows rows(grid);
  const KeptPoints kept_points = Thinning(cloud, grid, rows).run();
  MergedPoints merged;
  merged.kept = flags_of(kept_points, grid, begin, end);
  merged.positions.assign(positions.begin() + begin, positions.begin() + end);
  if (!normals.empty()) merged.normals.assign(normals.begin() + begin, normals.begin() + end);
  const auto groups = groups_of(cloud, grid, rows, kept_points);
  for (std::size_t first = 0, last = 0; first < groups.size(); first = last) {
    const std::uint32_t kept = groups[first].first;
    Vec3 shift, normal;
    for (; last < groups.size() && groups[last].first == kept; ++last) {
      shift = shift + (positions[groups[last].second] - positions[kept]);
      if (!normals.empty()) normal = normal + normals[groups[last].second];
    }
    if (kept < begin || kept >= end || last - first < 2) continue;
    merged.positions[kept - begin] = positions[kept] + shift / static_cast<double>(last - first);
    if (!normals.empty() && squared_norm(normal) > 0.0)
      merged.normals[kept - begin] = normalized(normal);
  }
  return merged;
}

}  // namespace orbweave
