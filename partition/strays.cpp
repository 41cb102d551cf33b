#include "partition/strays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <vector>

namespace orbweave {
namespace {

/// The points between two values of a coordinate.
struct Slab {
  double begin = 0.0;
  double end = 0.0;
  std::uint64_t points = 0;
};
using Slabs = std::vector<Slab>;

/// Points that are put aside at each end of an axis.
std::uint64_t points_aside(std::uint64_t points) {
  constexpr std::uint64_t kPerHundred = 100;
  constexpr std::uint64_t kFew = 3;
  if (points == 0) return 0;
  return std::max(points / kPerHundred, std::min(kFew, (points - 1) / 4));
}

/// Slabs [first, last] of an axis.
struct Range {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// What is left of an axis's points when `aside` of them are put aside at each end.
Range without_ends(const Slabs& slabs, std::uint64_t aside) {
  Range range{0, slabs.size() - 1};
  std::uint64_t before = 0, after = 0;
  while ((before += slabs[range.first].points) <= aside) ++range.first;
  while ((after += slabs[range.last].points) <= aside) --range.last;
  return range;
}

double extent_of(const Slabs& slabs, Range range) {
  return slabs[range.last].end - slabs[range.first].begin;
}

constexpr std::size_t kCoarseSlabs = 4096;

/// Equal slabs between the bounds, empty ones included.
std::array<Slabs, 3> coarse_slabs(const PointCounts& grid) {
  const Box& bounds = grid.bounds();
  std::array<Slabs, 3> slabs;
  for (int axis = 0; axis < 3; ++axis) {
    slabs[axis].resize(kCoarseSlabs);
    const double width = bounds.extent()[axis] / kCoarseSlabs;
    for (std::size_t i = 0; i < kCoarseSlabs; ++i) {
      slabs[axis][i].begin = bounds.min[axis] + static_cast<double>(i) * width;
      slabs[axis][i].end = bounds.min[axis] + static_cast<double>(i + 1) * width;
    }
  }
  const Vec3 extent = bounds.extent();
  grid.for_each_place([&](Vec3 corner, double /*side*/, std::uint64_t count) {
    for (int axis = 0; axis < 3; ++axis) {
      const double at = extent[axis] > 0.0
                            ? (corner[axis] - bounds.min[axis]) / extent[axis] * kCoarseSlabs
                            : 0.0;
      const double inside = std::clamp(at, 0.0, static_cast<double>(kCoarseSlabs - 1));
      slabs[axis][static_cast<std::size_t>(inside)].points += count;
    }
  });
  return slabs;
}

/// Whether most of the points lie in so small a part of the bounds that there may be strays.
bool may_have_strays(const PointCounts& grid) {
  const std::uint64_t aside = points_aside(grid.points());
  const double extent = grid.bounds().largest_extent();
  for (const Slabs& slabs : coarse_slabs(grid)) {
    // A cell may reach over two of the slabs.
    const double most = extent_of(slabs, without_ends(slabs, aside));
    if (most > extent * (2.0 / kStrayExtents)) return false;
  }
  return true;
}

/// One slab per coordinate of points, or per row of cells that holds any, in order; clipped to the
/// bounds.
Slabs slabs_along(const PointCounts& grid, int axis) {
  constexpr std::size_t kRoom = std::size_t{1} << 16;
  Slabs slabs;
  std::size_t merged = 0;
  const auto merge = [&] {
    std::sort(slabs.begin(), slabs.end(),
              [](const Slab& a, const Slab& b) { return a.begin < b.begin; });
    std::size_t kept = 0;
    for (const Slab& slab : slabs) {
      if (kept > 0 && slabs[kept - 1].begin == slab.begin)
        slabs[kept - 1].points += slab.points;
      else
        slabs[kept++] = slab;
    }
    slabs.resize(kept);
    merged = kept;
  };
  grid.for_each_place([&](Vec3 corner, double side, std::uint64_t count) {
    slabs.push_back({corner[axis], corner[axis] + side, count});
    if (slabs.size() > 2 * merged + kRoom) merge();
  });
  merge();
  slabs.front().begin = std::max(slabs.front().begin, grid.bounds().min[axis]);
  slabs.back().end = std::min(slabs.back().end, grid.bounds().max[axis]);
  return slabs;
}

/// The box that is left when the points aside are taken off both ends of every axis.
Box middle_box(const PointCounts& grid) {
  const std::uint64_t aside = points_aside(grid.points());
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const Slabs slabs = slabs_along(grid, axis);
    const Range range = without_ends(slabs, aside);
    box.min[axis] = slabs[range.first].begin;
    box.max[axis] = slabs[range.last].end;
  }
  return box;
}

/// How far the points of a place lie out of a box, each along the axis on which that is farthest;
/// 0: not at all. Where in a cell its points lie is not known: at least at its near side and at
/// most at its far one.
struct Reach {
  double least = 0.0;
  double most = 0.0;
};

Reach reach_out_of(const Box& box, const Box& place) {
  Reach reach;
  for (int axis = 0; axis < 3; ++axis) {
    reach.least =
        std::max({reach.least, box.min[axis] - place.max[axis], place.min[axis] - box.max[axis]});
    reach.most =
        std::max({reach.most, box.min[axis] - place.min[axis], place.max[axis] - box.max[axis]});
  }
  return reach;
}

/// Places whose points lie out of the middle box by lengths that differ by less than a factor of
/// two, as far as is known.
struct Shell {
  Reach reach{std::numeric_limits<double>::infinity(), 0.0};
  Box box;
  std::uint64_t points = 0;
};

/// By the exponents of the least reaches, ascending; places that touch the middle box are the first
/// shell.
std::map<int, Shell> shells_around(const Box& middle, const PointCounts& grid) {
  std::map<int, Shell> shells;
  grid.for_each_place([&](Vec3 corner, double side, std::uint64_t count) {
    // Cells at the border of the cloud hold no points beyond its bounds.
    const Vec3 end = corner + Vec3{side, side, side};
    Box place;
    for (int axis = 0; axis < 3; ++axis) {
      place.min[axis] = std::max(corner[axis], grid.bounds().min[axis]);
      place.max[axis] = std::min(end[axis], grid.bounds().max[axis]);
    }
    const Reach reach = reach_out_of(middle, place);
    Shell& shell =
        shells[reach.least > 0.0 ? std::ilogb(reach.least) : std::numeric_limits<int>::min()];
    shell.reach.least = std::min(shell.reach.least, reach.least);
    shell.reach.most = std::max(shell.reach.most, reach.most);
    shell.box.extend(place);
    shell.points += count;
  });
  return shells;
}

}  // namespace

std::optional<Box> box_without_strays(const PointCounts& grid) {
  if (grid.points() == 0 || !may_have_strays(grid)) return std::nullopt;
  const Box middle = middle_box(grid);
  Box body = middle;
  double reach = 0.0;
  std::uint64_t points = 0;
  // A gap of kStrayExtents extents is wider than a shell: no such gap lies within a shell. Of cells
  // the gap is the least possible and the body the largest: no measured point is taken for a stray.
  for (const auto& [exponent, shell] : shells_around(middle, grid)) {
    if (shell.reach.least - reach > kStrayExtents * body.largest_extent()) {
      // What is put aside along each axis may be most of few points, as of the corners of an
      // octahedron: what is left of them is no body.
      if (2 * points < grid.points()) return std::nullopt;
      return body;
    }
    points += shell.points;
    reach = std::max(reach, shell.reach.most);
    body.extend(shell.box);
  }
  return std::nullopt;
}

}  // namespace orbweave
