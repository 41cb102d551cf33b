// Points that are left out of a cloud, counted by reason.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace orbweave {

/// Points left out, by reason.
using DroppedPoints = std::map<std::string, std::uint64_t>;

/// Why the stages of a job leave a point out. What a file's format leaves out has texts of its own
/// (PointSource::left_out).
enum class DropReason : std::uint8_t {
  kNone,
  kCoordinateNotFinite,
  kNoDataValue,
  kBeyondRange,
  kMissingReturn,
  kStray,
  kNormalNotFinite,
  kZeroNormal,
  kDuplicate,
  kOutlier,
  kMerged,
  kThinned,
  kTooFewNeighbors,
  kCluster,
  kNoSurface,
};

/// Why a point outside of the crop of a job is left out, and a part of a file that lies outside.
inline constexpr const char* kOutsideCrop = "outside the crop";

/// Why a point is left out that was measured when the place of the scanner is unknown.
inline constexpr const char* kOutsideTrajectory = "at a time that the trajectory does not cover";

/// "exact duplicate"; empty for kNone. The keys of DroppedPoints.
const char* text_of(DropReason reason);

}  // namespace orbweave
