#include "engine/validation/odd_scans.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace orbweave {
namespace {

/// Fewer say nothing about a scan.
constexpr std::uint64_t kFewestPoints = 100;

/// How many of one unit another one is: metres, decimetres, centimetres, millimetres, feet, inches.
constexpr std::array kUnitFactors = {1000.0, 100.0, 10.0, 39.37007874, 12.0,
                                     304.8,  30.48, 25.4, 3.280839895, 2.54};

/// Scans that are no farther from each other than some times their sizes.
struct Group {
  std::vector<std::size_t> scans;
  Box bounds;
  std::uint64_t points = 0;
};

/// Along the axis where it is widest; 0 where the boxes overlap along all.
double gap_between(const Box& a, const Box& b) {
  double gap = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    gap = std::max({gap, a.min[axis] - b.max[axis], b.min[axis] - a.max[axis]});
  return gap;
}

bool are_apart(const Box& a, const Box& b, double sizes) {
  return gap_between(a, b) > sizes * std::max(a.diagonal(), b.diagonal());
}

void join(const Group& from, Group& to) {
  to.scans.insert(to.scans.end(), from.scans.begin(), from.scans.end());
  to.bounds.extend(from.bounds);
  to.points += from.points;
}

/// Joins groups until all are apart by more than `sizes` of the larger. A joined group reaches
/// farther than its parts, so that the result does not depend on the order.
std::vector<Group> joined(std::vector<Group> groups, double sizes) {
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<Group> apart;
    for (Group& group : groups) {
      const auto near = std::ranges::find_if(
          apart, [&](const Group& g) { return !are_apart(g.bounds, group.bounds, sizes); });
      if (near == apart.end()) {
        apart.push_back(std::move(group));
      } else {
        join(group, *near);
        changed = true;
      }
    }
    groups = std::move(apart);
  }
  for (Group& group : groups) std::ranges::sort(group.scans);
  return groups;
}

Box scaled(const Box& box, double factor, Vec3 about) {
  return {about + factor * (box.min - about), about + factor * (box.max - about)};
}

/// The factor between two units that brings the group among the others, about the world's zero or
/// about the origin of its first scan; 0: none does. Of several the one whose sizes are most alike.
double factor_to(const Group& others, const Group& group, Vec3 origin) {
  const double size = others.bounds.diagonal();
  double best = 0.0, best_ratio = 20.0;  // neither is to be a speck in the other
  for (const double units : kUnitFactors)
    for (const double factor : {units, 1.0 / units})
      for (const Vec3 about : {Vec3{}, origin}) {
        const Box box = scaled(group.bounds, factor, about);
        const double ratio = std::max(box.diagonal() / size, size / box.diagonal());
        if (!box.intersects(others.bounds) || !(ratio < best_ratio)) continue;
        best = factor;
        best_ratio = ratio;
      }
  return best;
}

/// Groups of scans that are apart from the largest group.
std::vector<OddScans> scans_apart(std::span<const PlacedScan> scans, std::vector<Group> groups) {
  constexpr double kSizes = 100.0, kSizesOfUnits = 10.0;
  groups = joined(std::move(groups), kSizesOfUnits);
  if (groups.size() < 2) return {};
  const auto has_fewer = [](const Group& a, const Group& b) {
    return a.scans.size() != b.scans.size() ? a.scans.size() < b.scans.size() : a.points < b.points;
  };
  std::ranges::iter_swap(groups.begin(), std::ranges::max_element(groups, has_fewer));
  const Group& most = groups.front();
  std::vector<OddScans> odd;
  for (const Group& group : std::span(groups).subspan(1)) {
    const double factor = factor_to(most, group, scans[group.scans.front()].origin);
    if (factor == 0.0 && !are_apart(group.bounds, most.bounds, kSizes)) continue;
    odd.push_back({.place = OddPlace::kApart,
                   .scans = group.scans,
                   .size = group.bounds.diagonal(),
                   .size_of_others = most.bounds.diagonal(),
                   .gap = gap_between(group.bounds, most.bounds),
                   .factor = factor});
  }
  std::ranges::sort(odd, {}, [](const OddScans& one) { return one.scans.front(); });
  return odd;
}

/// About the distance between points of a surface that fills the bounds.
double spacing_in(const PlacedScan& scan) {
  const Vec3 side = scan.bounds.extent();
  const double area = side.x * side.y + side.y * side.z + side.z * side.x;
  return std::sqrt(area / static_cast<double>(scan.points));
}

double middle_spacing(std::span<const PlacedScan> scans, std::span<const std::size_t> some) {
  std::vector<double> spacings;
  for (const std::size_t i : some) spacings.push_back(spacing_in(scans[i]));
  const auto middle = spacings.begin() + static_cast<std::ptrdiff_t>(spacings.size() / 2);
  std::ranges::nth_element(spacings, middle);
  return *middle;
}

/// Scans beyond the widest gap between sizes, where that is wide enough.
std::vector<OddScans> scans_of_other_size(std::span<const PlacedScan> scans,
                                          std::vector<std::size_t> by_size) {
  constexpr double kRatio = 300.0, kSpacingRatio = 30.0;
  const auto size_of = [&](std::size_t i) { return scans[i].bounds.diagonal(); };
  std::erase_if(by_size, [&](std::size_t i) { return !(spacing_in(scans[i]) > 0.0); });
  if (by_size.size() < 2) return {};
  std::ranges::stable_sort(by_size, {}, size_of);
  std::size_t cut = 1;
  const auto ratio_at = [&](std::size_t i) {
    return size_of(by_size[i]) / size_of(by_size[i - 1]);
  };
  for (std::size_t i = 2; i < by_size.size(); ++i)
    if (ratio_at(i) > ratio_at(cut)) cut = i;
  if (ratio_at(cut) < kRatio) return {};
  const auto smaller = std::span(by_size).first(cut), larger = std::span(by_size).subspan(cut);
  if (middle_spacing(scans, larger) < kSpacingRatio * middle_spacing(scans, smaller)) return {};
  const bool are_larger = larger.size() <= smaller.size();
  const auto few = are_larger ? larger : smaller;
  OddScans odd;
  odd.place = are_larger ? OddPlace::kLarger : OddPlace::kSmaller;
  odd.scans.assign(few.begin(), few.end());
  std::ranges::sort(odd.scans);
  odd.size = size_of(by_size[are_larger ? cut : cut - 1]);
  odd.size_of_others = size_of(by_size[are_larger ? cut - 1 : cut]);
  return {odd};
}

}  // namespace

std::vector<OddScans> odd_scans(std::span<const PlacedScan> scans) {
  std::vector<Group> groups;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    if (scans[i].points < kFewestPoints) continue;
    groups.push_back({{i}, scans[i].bounds, scans[i].points});
    all.push_back(i);
  }
  std::vector<OddScans> odd = scans_apart(scans, std::move(groups));
  return odd.empty() ? scans_of_other_size(scans, std::move(all)) : odd;
}

}  // namespace orbweave
