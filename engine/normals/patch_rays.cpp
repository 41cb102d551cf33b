#include "engine/normals/patch_rays.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace orbweave {
namespace {

/// Cells beyond have this number: their own might not fit.
constexpr double kFarthestCell = 0x1p60;
/// An area vector that is smaller, beside the area, is the rounding of a sum that is zero.
constexpr double kLeastCoherence = 1e-9;
/// Around a patch's bounds, in distances of its points.
constexpr double kMargin = 1.5;
constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

PatchRays::PatchRays(std::span<const PatchSum> sums, double cell,
                     std::span<const std::uint8_t> turn, std::span<const std::uint32_t> part)
    : sums_(sums), part_(part), cell_(cell), planes_(sums.size()), by_cell_(sums.size()) {
  if (sums.empty()) return;
  lowest_.fill(std::numeric_limits<std::int64_t>::max());
  highest_.fill(std::numeric_limits<std::int64_t>::min());
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const double area = norm(sums[v].area_normal);
    if (area > 0.0 && coherence(sums[v]) > kLeastCoherence) {
      const double sign = !turn.empty() && turn[v] != 0 ? -1.0 : 1.0;
      planes_[v] = {(sign / area) * sums[v].area_normal, sign / area * sums[v].flux,
                    std::sqrt(area / static_cast<double>(sums[v].points))};
    }
    const Place place = cell_of(sums[v].flux_origin);
    for (int axis = 0; axis < 3; ++axis) {
      lowest_[axis] = std::min(lowest_[axis], place[axis]);
      highest_[axis] = std::max(highest_[axis], place[axis]);
    }
  }
  std::iota(by_cell_.begin(), by_cell_.end(), 0u);
  std::vector<Place> cells(sums.size());
  for (std::uint32_t v = 0; v < sums.size(); ++v) cells[v] = counted(cell_of(sums[v].flux_origin));
  std::stable_sort(by_cell_.begin(), by_cell_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return cells[a] < cells[b]; });
  rows_of_cell_.reserve(sums.size());
  for (std::uint32_t row = 0; row < by_cell_.size(); ++row) {
    const auto [at, is_new] = rows_of_cell_.try_emplace(cells[by_cell_[row]], row, row + 1);
    if (!is_new) at->second.second = row + 1;
  }
  blocks_ = CellBlocks(cells);
}

/// The corner of a cell is a multiple of its side, a power of two: nothing is rounded.
PatchRays::Place PatchRays::cell_of(Vec3 position) const {
  Place place;
  for (int axis = 0; axis < 3; ++axis)
    place[axis] = static_cast<std::int64_t>(
        std::clamp(std::floor(position[axis] / cell_), -kFarthestCell, kFarthestCell));
  return place;
}

PatchRays::Place PatchRays::counted(const Place& place) const {
  return {place[0] - lowest_[0], place[1] - lowest_[1], place[2] - lowest_[2]};
}

Vec3 PatchRays::middle(std::uint32_t patch) const {
  const PatchSum& sum = sums_[patch];
  const Plane& plane = planes_[patch];
  const Vec3 center = center_of(sum);
  return center + (plane.offset - dot(plane.normal, center - sum.flux_origin)) * plane.normal;
}

double PatchRays::distance_to(std::uint32_t patch, Vec3 origin, Vec3 direction) const {
  // Planes that a ray nearly lies in say nothing.
  constexpr double kGrazing = 0.03;
  const Plane& plane = planes_[patch];
  const double along = dot(plane.normal, direction);
  if (std::abs(along) < kGrazing) return kNever;
  const PatchSum& sum = sums_[patch];
  const double distance = (plane.offset - dot(plane.normal, origin - sum.flux_origin)) / along;
  if (!(distance > 0.0)) return kNever;
  const Vec3 at = origin + distance * direction;
  const double margin = kMargin * plane.spacing;
  for (int axis = 0; axis < 3; ++axis)
    if (at[axis] < sum.lowest[axis] - margin || at[axis] > sum.highest[axis] + margin)
      return kNever;
  return distance;
}

bool PatchRays::is_beside(std::uint32_t from, std::uint32_t patch) const {
  const double margin = kMargin * (planes_[from].spacing + planes_[patch].spacing);
  const PatchSum &own = sums_[from], &other = sums_[patch];
  for (int axis = 0; axis < 3; ++axis)
    if (other.lowest[axis] - margin > own.highest[axis] ||
        other.highest[axis] + margin < own.lowest[axis])
      return false;
  return true;
}

bool PatchRays::is_same_layer(std::uint32_t from, std::uint32_t patch, Vec3 direction) const {
  constexpr double kAlike = 0.5;  // cosine
  if (!part_.empty() && part_[from] != part_[patch]) return false;
  const Vec3 own = planes_[from].normal, other = planes_[patch].normal;
  return dot(own, other) > kAlike && (dot(own, direction) > 0.0) == (dot(other, direction) > 0.0) &&
         is_beside(from, patch);
}

/// The cells that a ray passes through, of those with patches all, of others some.
class PatchRays::Walk {
 public:
  Walk(const PatchRays& rays, Vec3 origin, Vec3 direction)
      : rays_(rays), place_(rays.cell_of(origin)) {
    for (int axis = 0; axis < 3; ++axis) {
      step_[axis] = direction[axis] > 0.0 ? 1 : direction[axis] < 0.0 ? -1 : 0;
      const double wall =
          rays.cell_ * static_cast<double>(place_[axis] + (step_[axis] > 0 ? 1 : 0));
      next_[axis] = step_[axis] == 0 ? kNever : (wall - origin[axis]) / direction[axis];
      between_[axis] = step_[axis] == 0 ? kNever : rays.cell_ / std::abs(direction[axis]);
    }
    cell_ = rays.counted(place_);
  }

  const Place& cell() const { return cell_; }
  /// Distance to the wall where the ray has entered the cell.
  double entered() const { return entered_; }

  /// Goes on behind the block of cells around this one that are empty, or to the next cell. False:
  /// the ray has left the patches' bounds for good.
  bool pass() {
    const int side_log = rays_.blocks_.empty_around(cell_);
    std::array<std::int64_t, 3> walls{};  // up to where the block, or the bounds, are left
    Vec3 left{kNever, kNever, kNever};
    for (int axis = 0; axis < 3; ++axis) {
      if (step_[axis] == 0) continue;
      walls[axis] = walls_to_pass(axis, side_log);
      left[axis] = next_[axis] + static_cast<double>(walls[axis] - 1) * between_[axis];
    }
    const int first = left.x <= left.y && left.x <= left.z ? 0 : left.y <= left.z ? 1 : 2;
    entered_ = left[first];
    if (!(entered_ < kNever)) return false;
    for (int axis = 0; axis < 3; ++axis)
      advance(axis, axis == first ? walls[axis] : walls_before(axis, walls[axis] - 1, first));
    cell_ = rays_.counted(place_);
    return step_[first] > 0 ? place_[first] <= rays_.highest_[first]
                            : place_[first] >= rays_.lowest_[first];
  }

 private:
  std::int64_t walls_to_pass(int axis, int side_log) const {
    const std::int64_t side = std::int64_t{1} << side_log;
    const std::int64_t within = cell_[axis] & (side - 1);
    const bool rises = step_[axis] > 0;
    const std::int64_t of_block = rises ? side - within : within + 1;
    const std::int64_t of_bounds =
        rises ? rays_.highest_[axis] - place_[axis] + 1 : place_[axis] - rays_.lowest_[axis] + 1;
    return std::max<std::int64_t>(1, std::min(of_block, of_bounds));
  }

  /// Of at most `most` walls along an axis those that the ray passes before it has entered what is
  /// behind the block by a wall of the axis `first`.
  std::int64_t walls_before(int axis, std::int64_t most, int first) const {
    const bool is_in_time = next_[axis] < entered_ || (next_[axis] == entered_ && axis < first);
    if (!is_in_time || most < 1) return 0;
    const double walls = 1.0 + std::floor((entered_ - next_[axis]) / between_[axis]);
    return walls < static_cast<double>(most) ? static_cast<std::int64_t>(walls) : most;
  }

  void advance(int axis, std::int64_t walls) {
    if (walls == 0) return;
    place_[axis] += walls * step_[axis];
    next_[axis] += static_cast<double>(walls) * between_[axis];
  }

  const PatchRays& rays_;
  Place place_, cell_{}, step_{};
  Vec3 next_, between_;  // along the ray, to the next wall of a cell and from wall to wall
  double entered_ = 0.0;
};

PatchRays::Hit PatchRays::first(std::uint32_t from, Vec3 direction) const {
  const Vec3 origin = middle(from);
  const double nearest = planes_[from].spacing;
  Walk walk(*this, origin, direction);
  do {
    Hit hit{kNothing, kNever};
    const auto rows = rows_of_cell_.find(walk.cell());
    if (rows != rows_of_cell_.end())
      for (std::uint32_t row = rows->second.first; row < rows->second.second; ++row) {
        const std::uint32_t patch = by_cell_[row];
        const double distance = patch == from ? kNever : distance_to(patch, origin, direction);
        if (!(distance > nearest && distance < hit.distance)) continue;
        if (is_same_layer(from, patch, direction)) continue;
        hit = {patch, distance};
      }
    if (hit.patch != kNothing) return hit;
  } while (walk.pass());
  return {kNothing, walk.entered()};
}

}  // namespace orbweave
