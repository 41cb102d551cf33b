// One scan of a job: a file's points in world coordinates, without the points that are not wanted
// and, on request, with the direction to the scanner.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/box.h"
#include "io/points/point_source.h"
#include "io/points/scan_pose.h"

namespace orbweave {

class PolygonArea;
class StopToken;
class Trajectory;

/// Which returns of a laser pulse are wanted.
enum class ReturnFilter { kAll, kFirst, kLast, kOnly };

/// Where a scanner of a merged cloud stood: the points whose attribute has this value were seen
/// from this place.
struct ScannerOfValue {
  std::string attribute;
  double value = 0.0;
  ScannerPlace place;
  friend bool operator==(const ScannerOfValue&, const ScannerOfValue&) = default;
};

/// "ATTRIBUTE=VALUE x y z", a place, or "ATTRIBUTE=VALUE x y z 0", a direction. Throws
/// std::invalid_argument, saying why.
ScannerOfValue parse_scanner_of_value(std::string_view text);

struct ScanOptions {
  RigidMotion motion{};  ///< from the scan's own coordinates to the world
  /// Where the scanner is, in the scan's own coordinates, whatever the file says.
  std::optional<ScannerPlace> scanner{};
  std::optional<ScannerPlace> usual_scanner{};  ///< likewise, where the file does not say
  /// Where the scanners of a merged cloud stood, by the value of one attribute; in its coordinates.
  /// Of points with other values the scanner is not known. Empty: one scanner for all points.
  std::vector<ScannerOfValue> scanners{};
  /// Where a scanner that moved was at the time of each point, in world coordinates; points at
  /// times that it does not cover are left out. Of use only `with_view`; null: no scanner moved.
  std::shared_ptr<const Trajectory> trajectory{};
  bool with_view = false;              ///< adds the attributes of view_fields()
  bool without_normals = false;        ///< normals of the file are not taken
  bool would_take_normals = false;     ///< but for other files, which have none: facts() tells
  bool without_attributes = false;     ///< nor are its attributes, once they have filtered
  std::vector<int> classes{};          ///< values of `classification` wanted, 0 to 255; empty: all
  std::vector<int> dropped_classes{};  ///< values that are not, where `classes` is empty
  ReturnFilter returns = ReturnFilter::kAll;  ///< by `return_number` and `number_of_returns`
  std::optional<Box> crop{};                  ///< world coordinates; points outside are left out
  std::shared_ptr<const PolygonArea> area{};  ///< likewise by x and y; null: everywhere
  std::uint64_t every = 1;  ///< keeps one in so many points, chosen by a hash of their coordinates
  const StopToken* stop = nullptr;  ///< looked at before each batch, where there is one
};

/// Wraps a scan. Points are selected by io/clouds/scan_selection.h; the others count as left out,
/// by reason. Throws Error (bad input) where the file lacks an attribute that is asked for; `file`
/// is for messages.
std::unique_ptr<PointSource> open_scan_source(std::unique_ptr<PointSource> source,
                                              const ScanOptions& options, const std::string& file);

}  // namespace orbweave
