#include "engine/normals/part_sides.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "io/box.h"

namespace orbweave {
namespace {

/// Parts that are smaller follow the simple rules; share of the area of all.
constexpr double kLeastArea = 0.002;

/// Of a part of the cloud, as its votes orient it.
struct Enclosed {
  Box bounds;
  Vec3 area_normal;
  double area = 0.0;  // summed without regard to directions, patch by patch
  double flux = 0.0;  // through the part, of the vectors from the centre of its bounds

  Vec3 center() const { return bounds.min + 0.5 * (bounds.max - bounds.min); }
};

/// A sheet whose area vector is this many times its flux per diagonal of the bounds is no shell:
/// which side bulges says little.
constexpr double kSheet = 20.0;
/// So much of a landscape's area adds up to an area vector, and that stands so upright; whatever
/// grows on it encloses next to nothing. A closed surface's adds up to nothing.
constexpr double kOpen = 0.15;
constexpr double kUpright = 0.7;

PartKind kind_of(const Enclosed& e) {
  const double open = norm(e.area_normal);
  if (open > kOpen * e.area && std::abs(e.area_normal.z) > kUpright * open)
    return PartKind::kLandscape;
  const double diagonal = norm(e.bounds.max - e.bounds.min);
  return open * diagonal > kSheet * std::abs(e.flux) ? PartKind::kSheet : PartKind::kShell;
}

/// Upward, or to the back, or to the right where a sheet stands upright.
bool points_down(Vec3 area_normal) {
  for (const double component : {area_normal.z, area_normal.y, area_normal.x})
    if (std::abs(component) > 0.1 * norm(area_normal)) return component < 0.0;
  return false;
}

/// Whether a part shows the wrong side. What is open has no inside: it points up either way.
bool is_turned_away(const Enclosed& e, PartKind kind, bool inward) {
  if (kind == PartKind::kLandscape) return e.area_normal.z < 0.0;
  if (kind == PartKind::kSheet) return points_down(e.area_normal);
  return inward ? e.flux > 0.0 : e.flux < 0.0;
}

std::vector<Enclosed> enclosed(std::span<const PatchSum> sums, const SignedParts& parts) {
  std::vector<Enclosed> of(sums.size());
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    of[parts.part[v]].bounds.extend(sums[v].lowest);
    of[parts.part[v]].bounds.extend(sums[v].highest);
  }
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    Enclosed& e = of[parts.part[v]];
    const double sign = parts.turn[v] ? -1.0 : 1.0;
    e.area_normal = e.area_normal + sign * sums[v].area_normal;
    e.area += norm(sums[v].area_normal);
    e.flux += sign * (sums[v].flux + dot(sums[v].area_normal, sums[v].flux_origin - e.center()));
  }
  return of;
}

/// The rows of parts that are large enough to be asked about.
RowsOfParts rows_of_parts(std::span<const PatchSum> sums, const SignedParts& parts,
                          std::span<const OrientedPart> found) {
  double total = 0.0;
  for (const OrientedPart& part : found) total += part.area;
  RowsOfParts rows;
  for (const OrientedPart& part : found)
    if (part.area > 0.0 && part.area >= kLeastArea * total) rows[part.first];
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const auto at = rows.find(parts.part[v]);
    if (at != rows.end() && norm(sums[v].area_normal) > 0.0) at->second.push_back(v);
  }
  return rows;
}

/// Turns parts where free space or density says that they were seen from their inside, and marks
/// those whose side is a guess.
class Judge {
 public:
  Judge(std::span<const PatchSum> sums, std::span<const std::uint8_t> turn,
        std::span<const std::uint8_t> is_settled, const RowsOfParts& rows,
        const PartSideOptions& options, std::vector<OrientedPart>& parts)
      : sums_(sums),
        turn_(turn),
        is_settled_(is_settled),
        rows_(rows),
        options_(options),
        parts_(parts) {}

  void run(const SpaceOfParts& space) {
    for (OrientedPart& part : parts_) {
      part.space = space.of_part[part.first];
      if (part.space.area > 0.0) judge_alone(part);
    }
    judge_surroundings(space.facing);
    judge_contents(space.facing);
  }

 private:
  /// Areas that speak for a side: this many to one against it.
  static constexpr double kClear = 3.0;

  void judge_alone(OrientedPart& part) {
    /// Furniture, reveals and walls between rooms make so much of a room; folds of a closed object
    /// that nothing outside can see less.
    constexpr double kInterior = 0.05, kDoubt = 0.02;
    if (is_settled_[part.first] || part.kind == PartKind::kLandscape) return;
    const double back = part.space.farther_back, front = part.space.farther_front;
    if (back >= kInterior * part.space.area && back >= kClear * front) {
      become_interior(part);
    } else if (part.kind == PartKind::kShell && is_dense_from_inside(part)) {
      become_interior(part);
    } else if (back >= kDoubt * part.space.area && kClear * back > front) {
      part.is_doubtful = true;
    }
  }

  static void become_interior(OrientedPart& part) {
    part.kind = PartKind::kInterior;
    part.is_turned = !part.is_turned;
    part.bulge = -part.bulge;
    part.is_doubtful = false;
  }

  bool is_dense_from_inside(OrientedPart& part) {
    constexpr std::size_t kSamples = 256;
    const std::vector<std::uint32_t>& rows = rows_.at(part.first);
    const std::size_t stride = (rows.size() + kSamples - 1) / kSamples;
    std::vector<DensitySample> samples;
    for (std::size_t k = 0; k < rows.size(); k += stride) {
      const PatchSum& sum = sums_[rows[k]];
      const double area = norm(sum.area_normal);
      samples.push_back({.position = sum.lowest + 0.5 * (sum.highest - sum.lowest),
                         .normal = (turn_[rows[k]] ? -1.0 : 1.0) / area * sum.area_normal,
                         .points = static_cast<double>(sum.points),
                         .area = area});
    }
    part.density = fit_density(samples, options_.stop);
    return part.density.is_seen_from_inside();
  }

  void judge_surroundings(std::span<const Facing>) {}
  void judge_contents(std::span<const Facing>) {}

  std::span<const PatchSum> sums_;
  std::span<const std::uint8_t> turn_;
  std::span<const std::uint8_t> is_settled_;
  const RowsOfParts& rows_;
  const PartSideOptions& options_;
  std::vector<OrientedPart>& parts_;
};

std::vector<OrientedPart> parts_by_shape(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const std::uint8_t> is_settled, bool inward) {
  const std::vector<Enclosed> of = enclosed(sums, parts);
  std::vector<OrientedPart> found;
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    if (parts.part[v] != v) continue;
    const Enclosed& e = of[v];
    OrientedPart part;
    part.first = v;
    part.center = e.center();
    part.area = e.area;
    part.kind = kind_of(e);
    part.is_turned = is_settled[v] == 0 && is_turned_away(e, part.kind, inward);
    part.openness = e.area > 0.0 ? norm(e.area_normal) / e.area : 0.0;
    const double scale = 0.5 * e.area * norm(e.bounds.max - e.bounds.min);
    part.bulge = scale > 0.0 ? (part.is_turned ? -e.flux : e.flux) / scale : 0.0;
    found.push_back(part);
  }
  return found;
}

}  // namespace

std::vector<OrientedPart> sides_of_parts(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const std::uint8_t> is_settled,
                                         const PartSideOptions& options) {
  std::vector<OrientedPart> found = parts_by_shape(sums, parts, is_settled, options.inward);
  if (!options.looks_for_interiors || !(options.cell > 0.0)) return found;
  std::vector<std::uint8_t> turn(sums.size());
  for (const OrientedPart& part : found) turn[part.first] = part.is_turned ? 1 : 0;
  for (std::uint32_t v = 0; v < sums.size(); ++v)
    if (parts.part[v] != v) turn[v] = turn[parts.part[v]];
  for (std::uint32_t v = 0; v < sums.size(); ++v) turn[v] ^= parts.turn[v];
  const RowsOfParts rows = rows_of_parts(sums, parts, found);
  const SpaceOfParts space = find_free_space(
      sums, options.cell, std::span(parts.part).first(sums.size()), turn, rows, options.stop);
  Judge(sums, turn, is_settled, rows, options, found).run(space);
  return found;
}

}  // namespace orbweave
