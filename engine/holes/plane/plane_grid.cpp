#include "engine/holes/plane/plane_grid.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>

namespace orbweave {
namespace {

// New points keep this many spacings from the rim's edges: the height of an equilateral triangle
// would be 0.87, and less makes flat triangles at the rim, more makes large ones.
constexpr double kClear = 0.6;
// Places nearer to the rim than this many spacings are not asked for their height: a point stays
// there only where the patch is steeper than 75 degrees. Where the rim is not steep, nor are those
// asked that have no room for a point: most small holes have none, and do without the heights.
constexpr double kRoom = 0.5 * kClear;
// Nested lattices either way of the mean spacing.
constexpr int kMostLevels = 6;
// A lattice is replaced by the next finer one where the spacing wanted is less than this many of
// its own: the mean spacing serves from 0.62 to 1.62 times itself.
constexpr double kFinerBelow = 0.62;
constexpr double kFinerBelowCoarse = 0.81;
// Beyond this many spacings from the rim the spacing wanted grows with the distance. The patch
// is the smoother the farther from what is known, and the error of a guess is far more than that of
// larger triangles there.
constexpr double kUngraded = 24.0;
// So far at least; a rim of many edges has so many points beside it that it does with fewer rows.
constexpr double kLeastUngraded = 2.0;
constexpr double kMostBeside = 80'000.0;

double ungraded_rows(std::uint64_t edges) {
  return std::clamp(kMostBeside / static_cast<double>(edges), kLeastUngraded, kUngraded);
}

// Lengths of the rim's edges: means over a few dozen arcs of it.
class RimSizing {
 public:
  explicit RimSizing(const Rim& rim, const std::vector<Vec3>& places) {
    constexpr std::size_t kMostArcs = 64;
    const std::size_t n = rim.corners.size();
    const std::size_t arcs = std::clamp<std::size_t>(n / kArcEdges, 1, kMostArcs);
    for (std::size_t arc = 0; arc < arcs; ++arc) {
      Arc mean;
      const std::size_t first = arc * n / arcs;
      const std::size_t last = (arc + 1) * n / arcs;
      for (std::size_t i = first; i < last; ++i) {
        mean.place = mean.place + places[i];
        mean.length += norm(rim.corners[(i + 1) % n] - rim.corners[i]);
      }
      const auto count = static_cast<double>(last - first);
      const double length = mean.length / count;
      arcs_.push_back({mean.place / count, length, 0.5 * mean.length});
      for (std::size_t i = first; i < last; i += kArcEdges)
        parts_.push_back(part_of(rim, places, i, std::min(i + kArcEdges, last)));
      first_part_.push_back(parts_.size());
    }
  }

  // How far the rim is, at least. Parts of arcs that cannot be nearest are not looked at.
  double distance(Vec3 x) const {
    std::size_t first = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t arc = 0; arc < arcs_.size(); ++arc) {
      const double bound = arcs_[arc].distance(x);
      if (bound >= least) continue;
      least = bound;
      first = arc;
    }
    double nearest = nearest_part(x, first);
    for (std::size_t arc = 0; arc < arcs_.size(); ++arc) {
      if (arc == first || arcs_[arc].distance(x) >= nearest) continue;
      nearest = std::min(nearest, nearest_part(x, arc));
    }
    return std::max(nearest, 0.0);
  }

  // Weighted by the inverse squares of distances.
  double at(Vec3 x) const {
    double sum = 0.0;
    double weights = 0.0;
    for (const Arc& arc : arcs_) {
      const double dx = x.x - arc.place.x;
      const double dy = x.y - arc.place.y;
      const double weight = 1.0 / (dx * dx + dy * dy + arc.length * arc.length);
      sum += weight * arc.length;
      weights += weight;
    }
    return sum / weights;
  }

 private:
  static constexpr std::size_t kArcEdges = 6;

  struct Arc {
    Vec3 place;
    double length = 0.0;
    double reach = 0.0;

    // At least: no part of an arc is farther from its place than half its length.
    double distance(Vec3 x) const {
      const double dx = x.x - place.x;
      const double dy = x.y - place.y;
      return std::sqrt(dx * dx + dy * dy) - reach;
    }
  };

  // Edges [first, last) as an arc.
  static Arc part_of(const Rim& rim, const std::vector<Vec3>& places, std::size_t first,
                     std::size_t last) {
    const std::size_t n = rim.corners.size();
    Arc part;
    for (std::size_t i = first; i < last; ++i) {
      part.place = part.place + places[i];
      part.length += norm(rim.corners[(i + 1) % n] - rim.corners[i]);
    }
    part.place = part.place / static_cast<double>(last - first);
    part.reach = 0.5 * part.length;
    return part;
  }

  double nearest_part(Vec3 x, std::size_t arc) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = first_part_[arc]; i < first_part_[arc + 1]; ++i)
      nearest = std::min(nearest, parts_[i].distance(x));
    return nearest;
  }

  std::vector<Arc> arcs_;
  std::vector<Arc> parts_;                     // of the arcs, a few edges each
  std::vector<std::size_t> first_part_ = {0};  // of each arc
};

class Lattice {
 public:
  Lattice(const Rim& rim, const PlaneOutline& outline, const HoleHeights& heights, bool graded,
          std::uint32_t most, const StopToken* stop)
      : spacing_(rim.spacing),
        ungraded_(ungraded_rows(rim.corners.size()) * rim.spacing),
        sizing_(rim, outline.polygon()),
        outline_(outline),
        heights_(heights),
        least_room_(heights.is_steep() ? kRoom : kClear),
        graded_(graded),
        most_(most),
        stop_(stop) {}

  std::optional<std::vector<GridPoint>> points() {
    const std::vector<Cell> cells = coarsest_cells();
    std::vector<std::vector<GridPoint>> points(cells.size());
    std::vector<char> is_done(cells.size(), 0);
    const auto visit_cell = [&](std::size_t c) {
      check_stop(stop_);
      is_done[c] = visit(cells[c].i, cells[c].j, kMostLevels, points[c]) ? 1 : 0;
    };
    // A hole of that many is one that others wait for.
    constexpr std::size_t kManyCells = 32;
    if (cells.size() < kManyCells) {
      for (std::size_t c = 0; c < cells.size(); ++c) visit_cell(c);
    } else {
      tbb::this_task_arena::isolate(
          [&] { tbb::parallel_for(std::size_t{0}, cells.size(), visit_cell); });
    }
    std::vector<GridPoint> all;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      if (is_done[c] == 0) return std::nullopt;
      all.insert(all.end(), points[c].begin(), points[c].end());
    }
    return all;
  }

 private:
  struct Cell {
    std::int64_t i = 0;
    std::int64_t j = 0;
  };

  // Corners of the coarsest lattice whose cells may have a share of the hole, row by row.
  std::vector<Cell> coarsest_cells() const {
    std::vector<Cell> cells;
    const double step = spacing_ * std::ldexp(1.0, kMostLevels);
    const double row = step * 0.5 * std::numbers::sqrt3;
    const Vec3 low = outline_.low();
    const Vec3 high = outline_.high();
    const auto index = [](double x) { return static_cast<std::int64_t>(std::floor(x)); };
    for (std::int64_t j = index(low.y / row) - 1; j <= index(high.y / row); ++j) {
      const double shift = 0.5 * static_cast<double>(j);
      // A cell reaches from its corner a step and a half along the row.
      for (std::int64_t i = index(low.x / step - shift) - 2; i <= index(high.x / step - shift);
           ++i) {
        cells.push_back({i, j});
      }
    }
    return cells;
  }

  // Corner (i, j) of the lattice of 2^level spacings, for its cell. False: too many points.
  bool visit(std::int64_t i, std::int64_t j, int level, std::vector<GridPoint>& points) const {
    const double step = spacing_ * std::ldexp(1.0, level);
    const double row = step * 0.5 * std::numbers::sqrt3;
    const Vec3 x{(static_cast<double>(i) + 0.5 * static_cast<double>(j)) * step,
                 static_cast<double>(j) * row, 0.0};
    if (is_outside(x, step, row)) return true;
    const bool inside = outline_.contains(x);
    const double room = inside ? outline_.distance(x) : 0.0;
    const double size = spacing_at(x);
    const bool evaluated = inside && level <= 0 && room >= least_room_ * std::min(size, step);
    GridPoint point = evaluated ? lifted(x) : GridPoint{x, {}};
    const double stretch = std::sqrt(1.0 + squared_norm(point.slope));
    const double wanted = size / std::sqrt(stretch);
    const double enough = level > 0 ? kFinerBelowCoarse : kFinerBelow;
    if (level > -kMostLevels && wanted < enough * step) {
      for (int half = 0; half < 4; ++half) {
        if (!visit(2 * i + half % 2, 2 * j + half / 2, level - 1, points)) return false;
      }
      return true;
    }
    if (!inside || room < clearance_at(x, std::min(wanted, step))) return true;
    if (found_.fetch_add(1, std::memory_order_relaxed) >= most_) return false;
    points.push_back(evaluated ? point : lifted(x));
    return true;
  }

  double spacing_at(Vec3 x) const {
    const double size = sizing_.at(x);
    if (!graded_) return size;
    return size * std::max(1.0, sizing_.distance(x) / ungraded_);
  }

  /// Least distance from the rim of a point at x, where points lie `spacing` apart. The outline
  /// tells no distance beyond its reach. A point whose spacing grows with the distance from the rim
  /// is farther away than that: several rows of points lie between.
  double clearance_at(Vec3 x, double spacing) const {
    const bool grows = graded_ && sizing_.distance(x) > ungraded_;
    return grows ? std::min(kClear * spacing, outline_.reach()) : kClear * spacing;
  }

  GridPoint lifted(Vec3 x) const {
    const auto [height, gradient] = heights_.at(x);
    return {{x.x, x.y, height}, gradient};
  }

  bool is_outside(Vec3 x, double step, double row) const {
    return x.x > outline_.high().x || x.y > outline_.high().y ||
           x.x + 1.5 * step < outline_.low().x || x.y + row < outline_.low().y;
  }

  double spacing_;
  double ungraded_;
  RimSizing sizing_;
  const PlaneOutline& outline_;
  const HoleHeights& heights_;
  double least_room_;
  bool graded_;
  std::uint32_t most_;
  const StopToken* stop_;
  mutable std::atomic<std::uint64_t> found_{0};  // points of all cells
};

}  // namespace

std::optional<std::vector<GridPoint>> plane_grid(const Rim& rim, const PlaneOutline& outline,
                                                 const HoleHeights& heights, bool graded,
                                                 std::uint32_t most, const StopToken* stop) {
  return Lattice(rim, outline, heights, graded, most, stop).points();
}

double expected_grid_points(std::uint64_t edges, bool graded) {
  // A disc has a point for each 0.87 squared spacings. A graded patch has as many points beyond the
  // ungraded rows as in them. Up to kMoreCounted times this estimate were counted.
  constexpr double kPerPoint = 0.87, kMoreCounted = 1.6;
  const auto rim = static_cast<double>(edges);
  const double disc = rim * rim / (4.0 * std::numbers::pi * kPerPoint);
  if (!graded) return disc;
  const double coarsest = std::ldexp(disc, -2 * kMostLevels);  // the spacing grows no further
  return std::min(disc, kMoreCounted * 2.0 * ungraded_rows(edges) * rim / kPerPoint + coarsest);
}

double grid_clearance(const Rim& rim) {
  constexpr double kMost = 4.0;  // spacings; long edges among short ones may have points closer
  double longest = rim.spacing;
  for (std::size_t i = 0; i < rim.corners.size(); ++i) {
    longest = std::max(longest, norm(rim.corners[(i + 1) % rim.corners.size()] - rim.corners[i]));
  }
  return kClear * std::min(longest, kMost * rim.spacing);
}

}  // namespace orbweave
