#include "engine/normals/patch_rays.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace orbweave {
namespace {

/// Cells along an axis that a key holds; clouds that are wider than that are searched in part.
constexpr std::int64_t kMostCells = std::int64_t{1} << 21;
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
    if (area > 0.0) {
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
  std::vector<std::uint64_t> keys(sums.size());
  for (std::uint32_t v = 0; v < sums.size(); ++v) keys[v] = key_of(cell_of(sums[v].flux_origin));
  std::stable_sort(by_cell_.begin(), by_cell_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  rows_of_cell_.reserve(sums.size());
  for (std::uint32_t row = 0; row < by_cell_.size(); ++row) {
    const auto [at, is_new] = rows_of_cell_.try_emplace(keys[by_cell_[row]], row, row + 1);
    if (!is_new) at->second.second = row + 1;
  }
}

/// The corner of a cell is a multiple of its side, a power of two: nothing is rounded.
PatchRays::Place PatchRays::cell_of(Vec3 position) const {
  Place place;
  for (int axis = 0; axis < 3; ++axis)
    place[axis] = static_cast<std::int64_t>(std::floor(position[axis] / cell_));
  return place;
}

std::uint64_t PatchRays::key_of(const Place& place) const {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis)
    key = key * kMostCells +
          static_cast<std::uint64_t>(std::min(place[axis] - lowest_[axis], kMostCells - 1));
  return key;
}

Vec3 PatchRays::middle(std::uint32_t patch) const {
  const PatchSum& sum = sums_[patch];
  const Plane& plane = planes_[patch];
  const Vec3 center = sum.lowest + 0.5 * (sum.highest - sum.lowest);
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

PatchRays::Hit PatchRays::first(std::uint32_t from, Vec3 direction) const {
  const Vec3 origin = middle(from);
  const double nearest = planes_[from].spacing;
  Place place = cell_of(origin);
  Place step{};
  Vec3 next, between;  // along the ray, to the next wall of a cell and from wall to wall
  for (int axis = 0; axis < 3; ++axis) {
    step[axis] = direction[axis] > 0.0 ? 1 : direction[axis] < 0.0 ? -1 : 0;
    const double wall = cell_ * static_cast<double>(place[axis] + (step[axis] > 0 ? 1 : 0));
    next[axis] = step[axis] == 0 ? kNever : (wall - origin[axis]) / direction[axis];
    between[axis] = step[axis] == 0 ? kNever : cell_ / std::abs(direction[axis]);
  }
  for (double entered = 0.0;;) {
    Hit hit{kNothing, kNever};
    const auto rows = rows_of_cell_.find(key_of(place));
    if (rows != rows_of_cell_.end())
      for (std::uint32_t row = rows->second.first; row < rows->second.second; ++row) {
        const std::uint32_t patch = by_cell_[row];
        const double distance = patch == from ? kNever : distance_to(patch, origin, direction);
        if (!(distance > nearest && distance < hit.distance)) continue;
        if (is_same_layer(from, patch, direction)) continue;
        hit = {patch, distance};
      }
    if (hit.patch != kNothing) return hit;
    const int axis = next.x <= next.y && next.x <= next.z ? 0 : next.y <= next.z ? 1 : 2;
    entered = next[axis];
    place[axis] += step[axis];
    next[axis] += between[axis];
    const bool has_left =
        step[axis] > 0 ? place[axis] > highest_[axis] : place[axis] < lowest_[axis];
    if (has_left) return {kNothing, entered};
  }
}

}  // namespace orbweave
