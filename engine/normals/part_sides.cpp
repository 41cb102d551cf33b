#include "engine/normals/part_sides.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

namespace orbweave {
namespace {

/// Parts that are smaller follow their shape alone; share of the area of all.
constexpr double kLeastArea = 0.002;
/// Areas that speak for a side: this many to one against it.
constexpr double kClear = 3.0;
/// So much of an interior's area has much more room within than without, where nothing from
/// outside can get to see it. Of the folds of a closed object a tenth of that is so hidden.
constexpr double kInterior = 0.008;

/// The rows of parts that are large enough to be asked about.
RowsOfParts rows_of_parts(std::span<const PatchSum> sums, const SignedParts& parts,
                          std::span<const OrientedPart> found) {
  double total = 0.0;
  for (const OrientedPart& part : found) total += part.shape.area;
  RowsOfParts rows;
  for (const OrientedPart& part : found)
    if (part.shape.area > 0.0 && part.shape.area >= kLeastArea * total) rows[part.shape.first];
  for (std::uint32_t v = 0; v < sums.size(); ++v) {
    const auto at = rows.find(parts.part[v]);
    if (at != rows.end() && norm(sums[v].area_normal) > 0.0) at->second.push_back(v);
  }
  return rows;
}

/// Turns parts where free space or density says that they were seen from their inside, and says
/// whose side is a guess.
class Judge {
 public:
  Judge(std::span<const PatchSum> sums, std::span<const std::uint8_t> turn, const RowsOfParts& rows,
        const PartSideOptions& options, std::vector<OrientedPart>& parts)
      : sums_(sums), turn_(turn), rows_(rows), options_(options), parts_(parts) {
    for (OrientedPart& part : parts) {
      by_first_[part.shape.first] = &part;
      total_ += part.shape.area;
    }
  }

  void run(const SpaceOfParts& space) {
    for (OrientedPart& part : parts_) {
      part.space = space.of_part[part.shape.first];
      if (part.side != PartSide::kSettled && part.space.area > 0.0) judge_alone(part);
    }
    for (const Facing& facing : space.facing) judge_surroundings(facing);
    for (const Facing& facing : space.facing) judge_contents(facing);
    for (OrientedPart& part : parts_)
      if (part.side == PartSide::kShape && part.doubt == PartDoubt::kNone) part.doubt = doubt(part);
  }

 private:
  /// A landscape that is nearly closed below: normals point into it from most sides.
  static bool is_bowl(const PartShape& shape, bool is_turned) {
    constexpr double kBowl = -0.2;
    return shape.kind == PartKind::kLandscape && (is_turned ? -shape.bulge : shape.bulge) < kBowl;
  }

  void judge_alone(OrientedPart& part) {
    const PartSpace& space = part.space;
    const double back = space.farther_back, front = space.farther_front;
    if (part.shape.kind == PartKind::kLandscape) {
      if (is_bowl(part.shape, part.is_turned)) judge_bowl(part);
    } else if (is_wide_within(part)) {
      turn(part, PartSide::kInterior);
    } else if (part.shape.kind == PartKind::kShell && is_dense_within(part)) {
      // Scanners close in front of every side of an object make the same densities.
      turn(part, PartSide::kInterior);
      part.doubt = part.shape.is_box ? PartDoubt::kBox : PartDoubt::kFreeSpace;
    } else if ((back >= kInterior * space.area && kClear * back > front) ||
               part.density.may_be_seen_from_inside()) {
      part.doubt = PartDoubt::kFreeSpace;
    } else if (2.0 * space.shut > space.area &&
               front <= std::max(kClear * back, 0.25 * space.shut)) {
      part.doubt = PartDoubt::kNested;
    }
  }

  /// Whether boards, reveals and walls between rooms say that free space is within: of a room whose
  /// windows and unseen parts leave little open, less of them is enough.
  static bool is_wide_within(const OrientedPart& part) {
    constexpr double kLeast = 0.005, kOpen = 0.25, kLittleOpen = 0.08, kMost = 2.0;
    // Leaves and noise are shut in by each other.
    constexpr double kSurface = 0.5;
    constexpr std::uint64_t kLeastPatches = 4;
    const PartSpace& space = part.space;
    if (space.cut_off < kLeastPatches || part.shape.surface < kSurface * part.shape.area)
      return false;
    if (space.farther_back < kMost * space.farther_front) return false;
    return space.farther_back >=
               (space.open_back < kLittleOpen ? kLeast : kInterior) * space.area &&
           space.open_back < kOpen;
  }

  /// A yard that was seen from within, or the outer side of a bowl.
  void judge_bowl(OrientedPart& part) {
    part.doubt = is_dense_within(part) ? PartDoubt::kNone : PartDoubt::kBowl;
  }

  void turn(OrientedPart& part, PartSide side) {
    part.side = side;
    part.doubt = PartDoubt::kNone;
    part.is_turned = !part.is_turned;
    is_changed_[part.shape.first] = true;
  }

  /// Whether scanners within the bounds explain the density; of a landscape, scanners above it.
  bool is_dense_within(OrientedPart& part) {
    // Of fewer, scanners anywhere explain too much.
    constexpr std::size_t kSamples = 500;
    // Smaller parts are not worth the time, nor a warning.
    constexpr double kLarge = 0.05;
    if (part.shape.area < kLarge * total_) return false;
    const std::vector<std::uint32_t>& rows = rows_.at(part.shape.first);
    const std::size_t stride = (rows.size() + kSamples - 1) / kSamples;
    const bool seen_at_front = part.shape.kind == PartKind::kLandscape;
    std::vector<DensitySample> samples;
    for (std::size_t k = 0; k < rows.size(); k += stride) {
      const PatchSum& sum = sums_[rows[k]];
      // Leaves, noise and corners have no one side that a scanner could light.
      if (surface_area(sum) == 0.0) continue;
      const bool is_turned = (turn_[rows[k]] != 0) != seen_at_front;
      samples.push_back({.position = center_of(sum),
                         .normal = (is_turned ? -1.0 : 1.0) * normalized(sum.area_normal),
                         .points = static_cast<double>(sum.points),
                         .area = sum.area > 0.0 ? sum.area : norm(sum.area_normal)});
    }
    part.density = fit_density(samples, options_.stop);
    return part.density.is_seen_from_inside();
  }

  bool is_changed(const OrientedPart& part) const { return is_changed_.contains(part.shape.first); }

  /// Votes for both showing each other the same side, as they are turned by now.
  double votes(const Facing& facing, const OrientedPart& from, const OrientedPart& to) const {
    return is_changed(from) == is_changed(to) ? facing.votes : -facing.votes;
  }

  /// A part that free space surrounds, shut in by another one, was seen from within that one.
  void judge_surroundings(const Facing& facing) {
    constexpr double kMost = 0.6, kSure = 0.5;
    // A smaller one may be dirt within an object.
    constexpr double kLarge = 0.01;
    const OrientedPart& inner = *by_first_.at(facing.from);
    OrientedPart& outer = *by_first_.at(facing.to);
    if (is_changed(inner) || inner.space.farther_front < kSure * inner.space.area) return;
    if (outer.side == PartSide::kSettled || outer.shape.kind == PartKind::kLandscape) return;
    if (facing.front < kMost * inner.space.area || outer.shape.area < inner.shape.area) return;
    const double agreement = votes(facing, inner, outer);
    if (std::abs(agreement) < kSure * facing.weight) return;
    if (agreement > 0.0 && outer.side == PartSide::kInterior) outer.doubt = PartDoubt::kNone;
    if (agreement > 0.0 || outer.side != PartSide::kShape) return;
    if (inner.shape.area >= kLarge * total_) {
      turn(outer, PartSide::kInterior);
    } else {
      outer.doubt = PartDoubt::kNested;
    }
  }

  /// What sees much of an interior shows it its front.
  void judge_contents(const Facing& facing) {
    constexpr double kMuch = 0.3, kSure = 0.5;  // of the rays to both sides; of the votes
    OrientedPart& part = *by_first_.at(facing.from);
    const OrientedPart& interior = *by_first_.at(facing.to);
    if (interior.side != PartSide::kInterior || part.side != PartSide::kShape) return;
    if (facing.weight < kMuch * 2.0 * part.space.area) return;
    const double agreement = votes(facing, part, interior);
    if (std::abs(agreement) < kSure * facing.weight) return;
    if (agreement < 0.0) turn(part, PartSide::kFacing);
    part.side = PartSide::kFacing;
    part.doubt = PartDoubt::kNone;
  }

  /// By shape alone.
  static PartDoubt doubt(const OrientedPart& part) {
    constexpr double kHalfOpen = 0.12, kLevel = 0.3;
    // What bulges so much has an outer side although a part of it is missing.
    constexpr double kRound = 0.3, kUpward = 0.1;
    const PartShape& shape = part.shape;
    const double bulge = part.is_turned ? -shape.bulge : shape.bulge;
    if (shape.kind == PartKind::kSheet) return PartDoubt::kSheet;
    if (shape.kind == PartKind::kLandscape) {
      const bool is_sure =
          shape.openness > kLevel || bulge > kUpward || part.density.is_seen_from_inside();
      return is_sure ? PartDoubt::kNone : PartDoubt::kHalfOpen;
    }
    if (shape.openness > kHalfOpen && bulge < kRound) return PartDoubt::kHalfOpen;
    if (shape.is_tube) return PartDoubt::kTube;
    const bool is_solid = part.space.farther_front > kClear * part.space.farther_back;
    return shape.is_box && !is_solid ? PartDoubt::kBox : PartDoubt::kNone;
  }

  std::span<const PatchSum> sums_;
  std::span<const std::uint8_t> turn_;  // by shape
  const RowsOfParts& rows_;
  const PartSideOptions& options_;
  std::vector<OrientedPart>& parts_;
  std::map<std::uint32_t, OrientedPart*> by_first_;
  std::map<std::uint32_t, bool> is_changed_;  // against turn_
  double total_ = 0.0;
};

std::vector<OrientedPart> sides_by_shape(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const std::uint8_t> is_settled, bool inward) {
  std::vector<OrientedPart> found;
  for (PartShape& shape : shapes_of_parts(sums, parts)) {
    OrientedPart& part = found.emplace_back();
    const bool settled = is_settled[shape.first] != 0;
    part.side = settled ? PartSide::kSettled : PartSide::kShape;
    part.is_turned = !settled && shows_wrong_side(shape, inward);
    part.shape = shape;
  }
  return found;
}

/// Of patches, on top of their sums.
std::vector<std::uint8_t> turns_by_shape(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const OrientedPart> found) {
  std::vector<std::uint8_t> turn_of(sums.size()), turn(sums.size());
  for (const OrientedPart& part : found) turn_of[part.shape.first] = part.is_turned ? 1 : 0;
  for (std::uint32_t v = 0; v < sums.size(); ++v) turn[v] = parts.turn[v] ^ turn_of[parts.part[v]];
  return turn;
}

}  // namespace

std::vector<OrientedPart> sides_of_parts(std::span<const PatchSum> sums, const SignedParts& parts,
                                         std::span<const std::uint8_t> is_settled,
                                         const PartSideOptions& options) {
  std::vector<OrientedPart> found = sides_by_shape(sums, parts, is_settled, options.inward);
  if (options.inward || !(options.cell > 0.0)) return found;
  const std::vector<std::uint8_t> turn = turns_by_shape(sums, parts, found);
  const RowsOfParts rows = rows_of_parts(sums, parts, found);
  const SpaceOfParts space = find_free_space(
      sums, options.cell, std::span(parts.part).first(sums.size()), turn, rows, options.stop);
  Judge(sums, turn, rows, options, found).run(space);
  return found;
}

}  // namespace orbweave
