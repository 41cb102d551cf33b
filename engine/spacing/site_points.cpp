#include "engine/spacing/site_points.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

#include "io/bounds.h"
#include "io/vec3_order.h"
#include "io/whole_loop.h"
#include "partition/radix_sort.h"

namespace orbweave {

std::uint64_t hash_of(Vec3 p) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto bits = std::bit_cast<std::uint64_t>(p[axis] == 0.0 ? 0.0 : p[axis]);
    hash = (hash ^ (bits & 0x800FFFFFFFFFFFFFu)) * 0x9E3779B97F4A7C15u;
    hash ^= hash >> 32;
  }
  return hash * 0xBF58476D1CE4E5B9u;
}

bool PointSelection::takes(Vec3 p) const { return hash_of(p) <= last; }

std::uint64_t points_of(std::span<const SpacingSite> sites) {
  std::uint64_t points = 0;
  for (const SpacingSite& site : sites) points += site.points.size();
  return points;
}

PointSelection select_points(std::span<const SpacingSite> sites, std::uint64_t wanted) {
  const std::uint64_t points = points_of(sites);
  if (points <= wanted) return {};
  return {~std::uint64_t{0} / points * wanted};
}

namespace {

/// True where each site's points are sorted and no two are equal.
bool are_distinct(std::span<const SpacingSite> sites) {
  std::atomic<bool> distinct = true;
  for_each_whole(sites.size(), [&](std::size_t s) {
    const std::vector<Vec3>& points = sites[s].points;
    if (std::adjacent_find(points.begin(), points.end(),
                           [](Vec3 a, Vec3 b) { return !comes_before(a, b); }) != points.end())
      distinct = false;
  });
  return distinct;
}

/// As std::sort, with looks at the request to stop.
void sort_by_comparisons(std::span<Vec3> points, const StopToken* stop) {
  constexpr std::size_t kBlock = std::size_t{1} << 16;
  check_stop(stop);
  if (points.size() <= kBlock) return std::sort(points.begin(), points.end(), comes_before);
  const std::size_t half = points.size() / 2;
  tbb::parallel_invoke([&] { sort_by_comparisons(points.first(half), stop); },
                       [&] { sort_by_comparisons(points.subspan(half), stop); });
  std::inplace_merge(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(half),
                     points.end(), comes_before);
}

/// Whole numbers in the order of the values, which are finite. Both zeros are one.
std::uint64_t ordered_bits(double value) {
  constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  const auto bits = std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value);
  return (bits & kSign) != 0 ? ~bits : bits | kSign;
}

/// Sorts by comes_before: all points by their first coordinates, then those that share one.
/// Millions of points are sorted in place by comparisons, which takes longer but no more memory.
void sort_points(std::vector<Vec3>& points, const StopToken* stop) {
  constexpr std::size_t kFew = std::size_t{1} << 10, kMost = std::size_t{1} << 21;
  constexpr std::size_t kGrain = 4096;
  if (points.size() <= kFew || points.size() > kMost) return sort_by_comparisons(points, stop);
  KeyList order(points.size());
  for_each_whole((points.size() + kGrain - 1) / kGrain, [&](std::size_t block) {
    check_stop(stop);
    const std::size_t end = std::min(points.size(), (block + 1) * kGrain);
    for (std::size_t i = block * kGrain; i < end; ++i)
      order[i] = {ordered_bits(points[i].x), static_cast<std::uint32_t>(i)};
  });
  radix_sort(order);
  check_loops_are_whole();
  std::vector<Vec3> sorted(points.size());
  for_each_whole((points.size() + kGrain - 1) / kGrain, [&](std::size_t block) {
    const std::size_t end = std::min(points.size(), (block + 1) * kGrain);
    for (std::size_t i = block * kGrain; i < end; ++i) sorted[i] = points[order[i].index];
  });
  const std::vector<std::uint32_t> runs = run_begins(order);
  check_loops_are_whole();
  for (std::size_t run = 0; run + 1 < runs.size(); ++run)
    if (runs[run + 1] - runs[run] > 1)
      sort_by_comparisons(std::span(sorted).subspan(runs[run], runs[run + 1] - runs[run]), stop);
  points.swap(sorted);
}

/// A value of an axis, along which points differ, that leaves about half of them below it.
double middle_of(std::span<const Vec3> points, int axis) {
  std::vector<double> values;
  values.reserve(points.size());
  for (const Vec3& p : points) values.push_back(p[axis]);
  const auto half = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), half, values.end());
  const double least = *std::min_element(values.begin(), values.end());
  if (*half > least) return *half;
  double next = std::numeric_limits<double>::infinity();
  for (const double value : values)
    if (value > least) next = std::min(next, value);
  return next;
}

}  // namespace

void keep_part(SpacingSite& site, std::size_t most, const StopToken* stop) {
  if (site.points.size() <= std::max<std::size_t>(most, 1)) return;
  while (site.points.size() > std::max<std::size_t>(most, 1)) {
    check_stop(stop);
    const Vec3 extent = bounds_of(site.points).extent();
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0
                     : extent.y >= extent.z                       ? 1
                                                                  : 2;
    const double middle = middle_of(site.points, axis);
    const bool upper = PointSelection{~std::uint64_t{0} / 2}.takes({middle, middle, middle});
    std::erase_if(site.points, [&](Vec3 p) { return (p[axis] < middle) == upper; });
    (upper ? site.box.min : site.box.max)[axis] = middle;
  }
  site.core = site.box;
}

void merge_duplicates(std::span<SpacingSite> sites, const StopToken* stop) {
  tbb::parallel_for(std::size_t{0}, sites.size(), [&](std::size_t i) {
    std::vector<Vec3>& points = sites[i].points;
    sort_points(points, stop);
    points.erase(std::unique(points.begin(), points.end()), points.end());
  });
}

DistinctSites::DistinctSites(std::span<const SpacingSite> sites, const StopToken* stop)
    : sites_(sites) {
  if (are_distinct(sites)) return;
  copies_.assign(sites.begin(), sites.end());
  merge_duplicates(copies_, stop);
  sites_ = copies_;
}

double distance_to_border(Vec3 p, const Box& box) {
  double distance = p.x - box.min.x;
  for (int axis = 0; axis < 3; ++axis)
    distance = std::min({distance, p[axis] - box.min[axis], box.max[axis] - p[axis]});
  return distance;
}

namespace {

std::string with_digits(double value, int digits) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, digits);
  return std::string(text.data(), end.ptr);
}

}  // namespace

std::string short_text(double value) { return with_digits(value, 4); }

std::string brief_text(double value) {
  return std::abs(value) < 10.0 ? with_digits(value, 2) : with_digits(std::round(value), 6);
}

Length readable_length(double value, double meters_per_unit) {
  constexpr double kFoot = 0.3048, kFeetDifferBy = 1e-5;  // that of 1959 and that of US surveys
  if (!(meters_per_unit > 0.0)) return {value, ""};
  if (std::abs(meters_per_unit - kFoot) < kFeetDifferBy) return {value, " ft"};
  const double meters = value * meters_per_unit;
  if (std::abs(meters) < 1.0) return {1e3 * meters, " mm"};
  if (std::abs(meters) < 1e3) return {meters, " m"};
  return {1e-3 * meters, " km"};
}

}  // namespace orbweave
