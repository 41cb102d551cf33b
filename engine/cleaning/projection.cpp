#include "engine/cleaning/projection.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

#include "engine/geometry/cell_rows.h"
#include "engine/geometry/local_surface.h"
#include "engine/geometry/neighbor_grid.h"
#include "io/error.h"
#include "io/first_touch.h"

namespace orbweave {
namespace {

/// A neighbour supports a normal when the cosine between the two is more than that,
constexpr double kSupports = 0.7;
/// and a normal counts as right when it has that share of the neighbours' weight: half of them do
/// at an edge or on a thin wall.
constexpr double kSupport = 0.5;
/// Normals of which the mean is shorter are of two sheets, and it tells nothing.
constexpr double kOneSheet = 0.4;
/// Means of normals around the reference normal; it settles fast.
constexpr int kMeans = 2;
/// Parts of a cell of the grid along each axis: points of one part may share a surface.
constexpr int kParts = 2;
/// A point farther from a shared surface, in radii, gets one of its own.
constexpr double kFarthestOff = 0.5;
/// Points in a cube of the radius as side, where a projection takes a millisecond per point.
constexpr double kMostInACell = 10000.0;
/// Squared distance in radii that still counts: a hair less than the halo that chunks are cut with.
constexpr double kReach = 1.0 - 1e-12;

Vec3 vector_of(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

/// Points that are projected onto one surface: that around their middle.
struct Group {
  Vec3 middle;
  Vec3 normal;  ///< unit; zero where there is none
  std::span<const std::uint32_t> points;
};

/// Projects the points of one cell of the grid after the other, a few groups of them at once.
class Projector {
 public:
  Projector(std::span<const Vec3> positions, std::span<const Vec3> normals,
            const ProjectionOptions& options, const CellRows& rows)
      : positions_(positions), normals_(normals), options_(options), rows_(rows) {}

  /// Copies the points around a cell into columns.
  void enter(std::uint32_t cell) {
    rows_.gather(cell, candidates_);
    around_.reserve(candidates_.size());
    for (NearPoints& near : near_) near.reserve(candidates_.size());
    const LaneColumns& to = around_.columns.points;
    std::uint32_t row = 0;
    for (const std::uint32_t i : candidates_) {
      const Vec3 p = positions_[i], n = normals_[i];
      to.x[row] = p.x;
      to.y[row] = p.y;
      to.z[row] = p.z;
      to.normal_x[row] = n.x;
      to.normal_y[row] = n.y;
      to.normal_z[row++] = n.z;
    }
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    std::fill_n(to.x + row, (4 - row % 4) % 4, kNowhere);
    around_.columns.count = row;
  }

  /// The local surfaces around the middles of at most kSurfacesAtOnce groups of the cell.
  void surfaces_at(std::span<const Group> groups, std::span<std::optional<LocalSurface>> surfaces) {
    std::array<SurfaceSamples, kSurfacesAtOnce> samples;
    for (std::size_t k = 0; k < groups.size(); ++k) {
      NearColumns& near = near_[k].columns;
      kernel_.find_near(around_.columns.points, around_.columns.count, &groups[k].middle.x,
                        1.0 / options_.radius, kReach, near);
      const Vec3 reference = reference_normal(near, groups[k].normal);
      samples[k] = {&near, kernel_.weigh(near, &reference.x, options_.oriented), reference};
    }
    fit_surfaces(std::span(samples).first(groups.size()), surfaces);
  }

 private:
  /// The group's own normal, or what those around suggest where they do not support it: one
  /// estimated in the thick of layers may point anywhere.
  Vec3 reference_normal(const NearColumns& near, Vec3 own) const {
    AgreementSums sums = agreement(near, own);
    Vec3 reference = own;
    // Normals of either sign have no mean: there, the own one has to do.
    if (options_.oriented && sums.support < kSupport * sums.weight) {
      const Vec3 mean = vector_of(sums.normals);
      if (norm(mean) > kOneSheet * sums.weight) {
        reference = normalized(mean);
        sums = agreement(near, reference);
      }
    }
    for (int mean = 0;;) {
      const Vec3 sum = vector_of(sums.agreeing);
      if (squared_norm(sum) > 0.0) reference = normalized(sum);
      if (++mean == kMeans) return reference;
      sums = agreement(near, reference);
    }
  }

  AgreementSums agreement(const NearColumns& near, Vec3 reference) const {
    AgreementSums sums;
    kernel_.agreement(near, &reference.x, options_.oriented, kSupports, sums);
    return sums;
  }

  std::span<const Vec3> positions_, normals_;
  ProjectionOptions options_;
  const CellRows& rows_;
  const SurfaceKernel& kernel_ = surface_kernel();
  std::vector<std::uint32_t> candidates_;
  NearPoints around_;  // the candidates
  std::array<NearPoints, kSurfacesAtOnce> near_;
};

/// The points of a cell of the grid in groups: those of a part of the cell whose normals agree.
class Grouping {
 public:
  Grouping(std::span<const Vec3> positions, std::span<const Vec3> normals,
           const ProjectionOptions& options)
      : positions_(positions), normals_(normals), options_(options) {}

  /// Replaces `groups` by those of `members` that have a point that is wanted. Valid until the next
  /// call.
  template <class IsWanted>
  void form(std::span<const std::uint32_t> members, const IsWanted& is_wanted,
            std::vector<Group>& groups) {
    groups.clear();
    sort_by_part(members);
    for (std::size_t first = 0, last = 0; first < rows_.size(); first = last) {
      while (last < rows_.size() && rows_[last].part == rows_[first].part) ++last;
      form_groups({points_.begin() + static_cast<std::ptrdiff_t>(first),
                   points_.begin() + static_cast<std::ptrdiff_t>(last)},
                  is_wanted, groups);
    }
  }

 private:
  struct Row {
    std::uint32_t part = 0, point = 0;
    friend auto operator<=>(const Row&, const Row&) = default;
  };

  void sort_by_part(std::span<const std::uint32_t> members) {
    rows_.clear();
    for (const std::uint32_t point : members)
      if (normals_[point] != Vec3{}) rows_.push_back({part_of(positions_[point]), point});
    std::sort(rows_.begin(), rows_.end());
    points_.clear();
    for (const Row& row : rows_) points_.push_back(row.point);
  }

  std::uint32_t part_of(Vec3 p) const {
    std::uint32_t part = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double in_cells = p[axis] / NeighborGrid::cell_side(options_.radius);
      const double share = kParts * (in_cells - std::floor(in_cells));
      part = kParts * part + static_cast<std::uint32_t>(share);
    }
    return part;
  }

  /// The first point that is left, and all whose normals agree with its own, are a group.
  template <class IsWanted>
  void form_groups(std::span<std::uint32_t> points, const IsWanted& is_wanted,
                   std::vector<Group>& groups) {
    while (!points.empty()) {
      const Vec3 first = normals_[points.front()];
      const auto agrees = [&](std::uint32_t point) {
        const double cosine = dot(normals_[point], first);
        return (options_.oriented ? cosine : std::abs(cosine)) > kSupports;
      };
      const auto rest = std::stable_partition(points.begin() + 1, points.end(), agrees);
      const std::span<const std::uint32_t> group(points.begin(), rest);
      if (std::any_of(group.begin(), group.end(), is_wanted)) groups.push_back(group_of(group));
      points = {rest, points.end()};
    }
  }

  Group group_of(std::span<const std::uint32_t> points) const {
    const Vec3 first = positions_[points.front()];
    Vec3 offsets, sum = normals_[points.front()];
    for (const std::uint32_t point : points.subspan(1)) {
      offsets = offsets + (positions_[point] - first);
      const Vec3 normal = normals_[point];
      sum = dot(normal, sum) < 0.0 ? sum - normal : sum + normal;
    }
    return {first + offsets / static_cast<double>(points.size()), normalized(sum), points};
  }

  std::span<const Vec3> positions_, normals_;
  ProjectionOptions options_;
  std::vector<Row> rows_;
  std::vector<std::uint32_t> points_;
};

/// A point's time is that of its neighbours, of which there are some three times as many as points
/// in its cell.
void refuse_too_many(const NeighborGrid& grid, std::size_t points, const std::string& radius_name) {
  double pairs = 0.0;
  for (std::uint32_t cell = 0; cell < grid.cells(); ++cell) {
    const auto members = static_cast<double>(grid.members(cell).size());
    pairs += members * members;
  }
  const double mean = pairs / static_cast<double>(points);
  if (!(mean > kMostInACell)) return;
  throw_usage(
      "the radius of smoothing is far wider than the points are apart",
      {.place = radius_name,
       .found = std::to_string(std::llround(mean)) + " points in an average cube of that side",
       .expected =
           "at most " + std::to_string(std::llround(kMostInACell)) + " (some 15 are the rule)",
       .advice = "Choose a smaller radius: about four times the distance between "
                 "neighbouring points."});
}

/// Projects the points of cells, one cell after the other.
class CellProjection {
 public:
  CellProjection(std::span<const Vec3> positions, std::span<const Vec3> normals,
                 std::uint32_t begin, std::uint32_t end, const ProjectionOptions& options,
                 std::span<const std::uint8_t> chosen, const NeighborGrid& grid,
                 const CellRows& rows, ProjectedPoints& result)
      : positions_(positions),
        normals_(normals),
        begin_(begin),
        end_(end),
        options_(options),
        chosen_(chosen),
        grid_(grid),
        projector_(positions, normals, options, rows),
        grouping_(positions, normals, options),
        result_(result) {}

  void project(std::uint32_t cell) {
    const auto members = grid_.members(cell);
    const auto wanted = [&](std::uint32_t point) { return is_wanted(point); };
    if (std::none_of(members.begin(), members.end(), wanted)) return;
    projector_.enter(cell);
    grouping_.form(members, wanted, groups_);
    alone_.clear();
    project_groups();
    groups_.clear();
    for (const std::uint32_t& point : alone_)
      groups_.push_back({positions_[point], normals_[point], {&point, 1}});
    project_groups();
  }

 private:
  bool is_wanted(std::uint32_t point) const {
    return point >= begin_ && point < end_ && normals_[point] != Vec3{} &&
           (chosen_.empty() || chosen_[point - begin_] != 0);
  }

  void project_groups() {
    std::array<std::optional<LocalSurface>, kSurfacesAtOnce> surfaces;
    for (std::size_t first = 0; first < groups_.size(); first += kSurfacesAtOnce) {
      check_stop(options_.stop);
      const auto groups = std::span<const Group>(groups_).subspan(
          first, std::min(kSurfacesAtOnce, groups_.size() - first));
      projector_.surfaces_at(groups, surfaces);
      for (std::size_t k = 0; k < groups.size(); ++k) move(groups[k], surfaces[k]);
    }
  }

  void move(const Group& group, const std::optional<LocalSurface>& surface) {
    for (const std::uint32_t point : group.points) {
      if (!is_wanted(point)) continue;
      const Vec3 offset = (positions_[point] - group.middle) / options_.radius;
      const double above = surface ? surface->distance_above(offset) : 0.0;
      const bool shares = group.points.size() > 1;
      if (shares && !(surface && std::abs(above) <= kFarthestOff)) {
        alone_.push_back(point);
      } else if (surface) {
        const std::uint32_t row = point - begin_;
        result_.positions[row] = positions_[point] - options_.radius * above * surface->normal;
        result_.normals[row] = surface->normal_at(offset);
        result_.moved[row] = 1;
      }
    }
  }

  std::span<const Vec3> positions_, normals_;
  std::uint32_t begin_, end_;
  ProjectionOptions options_;
  std::span<const std::uint8_t> chosen_;
  const NeighborGrid& grid_;
  Projector projector_;
  Grouping grouping_;
  ProjectedPoints& result_;
  std::vector<Group> groups_;
  std::vector<std::uint32_t> alone_;
};

}  // namespace

double shared_side(const ProjectionOptions& options) {
  return NeighborGrid::cell_side(options.radius) / kParts;
}

double projection_halo(const ProjectionOptions& options) {
  // The middle of a point's group lies in its part of a cell, and so do the others of the group.
  return options.radius + std::numbers::sqrt3 * shared_side(options);
}

ProjectedPoints project_points(std::span<const Vec3> positions, std::span<const Vec3> normals,
                               std::uint32_t begin, std::uint32_t end,
                               const ProjectionOptions& options,
                               std::span<const std::uint8_t> chosen) {
  ProjectedPoints result = as_given(positions, normals, begin, end);
  project_chosen(positions, normals, begin, end, options, chosen, result);
  return result;
}

ProjectedPoints as_given(std::span<const Vec3> positions, std::span<const Vec3> normals,
                         std::uint32_t begin, std::uint32_t end) {
  ProjectedPoints result;
  reserve_touched(result.positions, end - begin);
  result.positions.assign(positions.begin() + begin, positions.begin() + end);
  reserve_touched(result.normals, end - begin);
  result.normals.assign(normals.begin() + begin, normals.begin() + end);
  result.moved.assign(end - begin, 0);
  return result;
}

void project_chosen(std::span<const Vec3> positions, std::span<const Vec3> normals,
                    std::uint32_t begin, std::uint32_t end, const ProjectionOptions& options,
                    std::span<const std::uint8_t> chosen, ProjectedPoints& result) {
  const NeighborGrid grid(positions, options.radius);
  refuse_too_many(grid, positions.size(), options.radius_name);
  const CellRows rows(grid);
  tbb::enumerable_thread_specific<CellProjection> projections([&] {
    return CellProjection(positions, normals, begin, end, options, chosen, grid, rows, result);
  });
  tbb::parallel_for(std::uint32_t{0}, grid.cells(),
                    [&](std::uint32_t cell) { projections.local().project(cell); });
}

}  // namespace orbweave
