#include "engine/normals/ground_patches.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "engine/geometry/disjoint_sets.h"
#include "engine/geometry/plane_axes.h"
#include "engine/normals/part_shape.h"

namespace orbweave {
namespace {

/// Fewer points at the bottom of a column may be noise below the ground. Far from a scanner the
/// ground has fewer per cell, and several patches make up the number.
constexpr std::uint64_t kLeastPoints = 12;
/// A patch of fewer points has no plane of its own.
constexpr std::uint64_t kLeastOfPatch = 4;
/// Surroundings of 3 columns of 1, 2, 4, ... cells; the widest are some 200 cells wide, which hold
/// a few thousand point spacings.
constexpr int kWidths = 7;
constexpr double kSlope = 0.5;
/// Cosine of the angle between a patch's normal and the vertical.
constexpr double kFlat = 0.7;

/// Where a patch stands: on the plane perpendicular to up, and how high.
struct Site {
  double x = 0.0, y = 0.0, height = 0.0;
};

std::vector<Site> sites_of(std::span<const PatchSum> sums, Vec3 up) {
  const PlaneAxes axes = plane_axes(up);
  std::vector<Site> sites;
  sites.reserve(sums.size());
  for (const PatchSum& sum : sums) {
    const Vec3 center = center_of(sum);
    sites.push_back({dot(center, axes.u), dot(center, axes.v), dot(center, up)});
  }
  return sites;
}

/// The height of the lowest patches of each column of a square lattice, up to which the column
/// holds enough points.
class Columns {
 public:
  Columns(std::span<const Site> sites, std::span<const PatchSum> sums, double side) : side_(side) {
    std::vector<Column> all;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const auto [x, y] = column_of(sites[i]);
      all.push_back({x, y, sites[i].height, sums[i].points});
    }
    std::sort(all.begin(), all.end());
    for (std::size_t i = 0; i < all.size();) {
      const Column& first = all[i];
      std::uint64_t points = 0;
      for (; i < all.size() && std::tie(all[i].x, all[i].y) == std::tie(first.x, first.y); ++i) {
        if (points < kLeastPoints && points + all[i].points >= kLeastPoints)
          columns_.push_back(all[i]);
        points += all[i].points;
      }
    }
  }

  /// In the column of a site and the eight around it; the site's own height where all are empty.
  double lowest_around(const Site& site) const {
    const auto [x, y] = column_of(site);
    double lowest = site.height;
    for (double column = x - 1.0; column <= x + 1.0; column += 1.0) {
      auto at = std::lower_bound(columns_.begin(), columns_.end(), std::tuple(column, y - 1.0),
                                 [](const Column& c, const std::tuple<double, double>& wanted) {
                                   return std::tie(c.x, c.y) < wanted;
                                 });
      for (; at != columns_.end() && at->x == column && at->y <= y + 1.0; ++at)
        lowest = std::min(lowest, at->height);
    }
    return lowest;
  }

 private:
  struct Column {
    double x = 0.0, y = 0.0, height = 0.0;
    std::uint64_t points = 0;
    friend auto operator<=>(const Column&, const Column&) = default;
  };

  std::array<double, 2> column_of(const Site& site) const {
    return {std::floor(site.x / side_), std::floor(site.y / side_)};
  }

  double side_;
  std::vector<Column> columns_;  // by x, then y; one of each
};

/// A shell that is no thin slab, or one that lacks its bottom; not a valley, whose ground it has.
bool is_round(const PartShape& shape) {
  constexpr double kRound = 0.3;
  if (shape.kind == PartKind::kSheet) return false;
  if (shape.kind == PartKind::kShell) return std::abs(shape.bulge) > kRound;
  return (shape.area_normal.z < 0.0 ? -shape.bulge : shape.bulge) > kRound;
}

/// The patches that votes connect with ground, but with little of it.
std::vector<std::uint32_t> rows_of_little_floor(std::span<const PatchSum> sums,
                                                std::span<const SignedEdge> edges, Vec3 up,
                                                std::span<const std::uint8_t> is_ground) {
  // Half of what faces up or down is the floor of a room; furniture stands on some of it, and
  // patches that bend up to a wall are no floor. What scanners see of the underside of a ball, and
  // is flat enough to be ground, is a tenth of that at most.
  constexpr double kLeastFloor = 0.15;
  DisjointSets connected(sums.size());
  for (const SignedEdge& edge : edges) connected.unite(edge.a, edge.b);
  std::vector<double> level(sums.size()), floor(sums.size());  // by part, as seen from above
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const double seen = std::abs(dot(sums[v].area_normal, up));
    level[connected.find(v)] += seen;
    if (is_ground[v]) floor[connected.find(v)] += seen;
  }
  std::vector<std::uint32_t> rows;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const std::uint32_t part = connected.find(v);
    if (floor[part] > 0.0 && floor[part] < kLeastFloor * level[part]) rows.push_back(v);
  }
  return rows;
}

/// The edges between some of the nodes, by their numbers among these. `rows`: ascending; an edge
/// has both of its nodes among them or none.
std::vector<SignedEdge> edges_among(std::span<const SignedEdge> edges,
                                    std::span<const std::uint32_t> rows, std::size_t nodes) {
  const auto absent = static_cast<std::uint32_t>(rows.size());
  std::vector<std::uint32_t> number_of(nodes, absent);
  for (std::uint32_t k = 0; k < absent; ++k) number_of[rows[k]] = k;
  std::vector<SignedEdge> among;
  for (const SignedEdge& edge : edges)
    if (number_of[edge.a] != absent)
      among.push_back({number_of[edge.a], number_of[edge.b], edge.votes, edge.weight});
  return among;
}

}  // namespace

std::vector<std::uint8_t> find_ground(std::span<const PatchSum> sums, double cell, Vec3 up,
                                      const StopToken* stop) {
  const std::vector<Site> sites = sites_of(sums, up);
  std::vector<std::uint8_t> is_ground(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i)
    is_ground[i] = sums[i].points >= kLeastOfPatch &&
                   std::abs(dot(sums[i].area_normal, up)) > kFlat * norm(sums[i].area_normal);
  double side = cell;
  for (int width = 0; width < kWidths; ++width, side *= 2.0) {
    const Columns columns(sites, sums, side);
    // Patches of the next column are two sides away at most, along an axis.
    const double drop = kSlope * 2.0 * side + cell;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (i % kStopBlock == 0) check_stop(stop);
      if (is_ground[i] && sites[i].height - columns.lowest_around(sites[i]) > drop)
        is_ground[i] = 0;
    }
  }
  return is_ground;
}

void leave_out_undersides(std::span<const PatchSum> sums, std::span<const SignedEdge> edges,
                          Vec3 up, std::span<std::uint8_t> is_ground, const StopToken* stop) {
  const std::vector<std::uint32_t> rows = rows_of_little_floor(sums, edges, up, is_ground);
  if (rows.empty()) return;
  std::vector<PatchSum> of_rows;
  for (const std::uint32_t row : rows) of_rows.push_back(sums[row]);
  const SignedParts parts = join_by_votes(static_cast<std::uint32_t>(rows.size()),
                                          edges_among(edges, rows, sums.size()), {.stop = stop});
  std::vector<std::uint8_t> is_object(rows.size());
  for (const PartShape& shape : shapes_of_parts(of_rows, parts))
    is_object[shape.first] = is_round(shape);
  for (std::size_t k = 0; k < rows.size(); ++k)
    if (is_object[parts.part[k]]) is_ground[rows[k]] = 0;
}

}  // namespace orbweave
