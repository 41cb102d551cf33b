#include "partition/point_filter.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "io/points/no_data.h"
#include "partition/strays.h"

namespace orbweave {
namespace {

/// Which of the origins a position is; their number: none of them. `origins` ascend by x.
std::size_t index_of(std::span<const Vec3> origins, Vec3 p) {
  auto origin = std::lower_bound(origins.begin(), origins.end(), p,
                                 [](const Vec3& a, const Vec3& b) { return a.x < b.x; });
  for (; origin != origins.end() && origin->x == p.x; ++origin)
    if (*origin == p) return static_cast<std::size_t>(origin - origins.begin());
  return origins.size();
}

bool is_among(std::span<const Vec3> origins, Vec3 p) {
  return index_of(origins, p) != origins.size();
}

/// Why a position is no measurement; kNone when it is one.
DropReason objection_to_position(Vec3 p, const PointFilter& filter) {
  if (!is_finite(p)) return DropReason::kCoordinateNotFinite;
  if (!filter.takes_no_data_values && holds_no_data_value(p)) return DropReason::kNoDataValue;
  if (!kUsableRange.contains(p)) return DropReason::kBeyondRange;
  if (is_among(filter.missing_returns, p)) return DropReason::kMissingReturn;
  return filter.within.contains(p) ? DropReason::kNone : DropReason::kStray;
}

/// Why a point is of no use; kNone when it is of use.
DropReason objection(const PointColumns& points, std::size_t i, const PointFilter& filter) {
  const DropReason reason = objection_to_position(points.positions[i], filter);
  if (reason != DropReason::kNone || points.normals.empty()) return reason;
  if (!is_finite(points.normals[i])) return DropReason::kNormalNotFinite;
  return squared_norm(points.normals[i]) > 0.0 ? DropReason::kNone : DropReason::kZeroNormal;
}

/// Counts a point of the filter's origins.
void count_at_origin(const PointFilter& filter, Vec3 p, FilteredPoints& found) {
  const std::size_t origin = index_of(filter.scan_origins, p);
  if (origin != filter.scan_origins.size()) ++found.at_scan_origins[origin];
}

void move_point(PointCloud& points, std::size_t from, std::size_t to) {
  points.positions[to] = points.positions[from];
  if (!points.normals.empty()) points.normals[to] = points.normals[from];
  const std::size_t bytes = points.schema.attribute_bytes();
  if (bytes != 0) {
    std::memcpy(points.attributes.data() + to * bytes, points.attributes.data() + from * bytes,
                bytes);
  }
}

/// A lone point at a scan's origin may be measured; several points at the very same place are not.
constexpr std::uint64_t kMostMeasuredAtOrigin = 1;

/// Each origin speaks for its own scan: a lone point there is measured whatever lies at others.
/// Empty once the points at such origins are left out.
std::vector<Vec3> origins_of_missing_returns(const PointFilter& filter,
                                             std::span<const std::uint64_t> at_scan_origins) {
  std::vector<Vec3> origins;
  for (std::size_t i = 0; i < at_scan_origins.size(); ++i)
    if (at_scan_origins[i] > kMostMeasuredAtOrigin) origins.push_back(filter.scan_origins[i]);
  return origins;
}

}  // namespace

FilteredPoints drop_unusable(PointCloud& points, const PointFilter& filter) {
  FilteredPoints selected;
  selected.at_scan_origins.assign(filter.scan_origins.size(), 0);
  const PointColumns columns = columns_of(points);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const DropReason reason = objection(columns, i, filter);
    if (reason != DropReason::kNone) {
      ++selected.dropped[text_of(reason)];
      continue;
    }
    count_at_origin(filter, points.positions[i], selected);
    if (kept != i) move_point(points, i, kept);
    ++kept;
  }
  points.positions.resize(kept);
  if (!points.normals.empty()) points.normals.resize(kept);
  points.attributes.resize(kept * points.schema.attribute_bytes());
  return selected;
}

FilteredPoints find_unusable(const PointColumns& points, const PointFilter& filter) {
  FilteredPoints found;
  found.at_scan_origins.assign(filter.scan_origins.size(), 0);
  for (std::size_t i = 0; i < points.positions.size(); ++i) {
    const DropReason reason = objection(points, i, filter);
    if (reason != DropReason::kNone)
      ++found.dropped[text_of(reason)];
    else
      count_at_origin(filter, points.positions[i], found);
  }
  return found;
}

PointFilter measurement_filter(std::vector<Vec3> scan_origins) {
  PointFilter filter;
  filter.takes_no_data_values = false;
  filter.scan_origins = std::move(scan_origins);
  return filter;
}

void add_origin_counts(std::vector<std::uint64_t>& to, std::span<const std::uint64_t> from) {
  to.resize(std::max(to.size(), from.size()), 0);
  for (std::size_t i = 0; i < from.size(); ++i) to[i] += from[i];
}

PointFilter narrowed(PointFilter filter, std::span<const std::uint64_t> at_scan_origins,
                     const PointCounts& counts) {
  std::vector<Vec3> missing = origins_of_missing_returns(filter, at_scan_origins);
  if (!missing.empty()) {
    filter.missing_returns = std::move(missing);
    return filter;  // the strays are looked for without these
  }
  if (const std::optional<Box> box = box_without_strays(counts)) filter.within = *box;
  return filter;
}

}  // namespace orbweave
