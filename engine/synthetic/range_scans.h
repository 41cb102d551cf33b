// Scans that virtual scanners make row by row: the points of one scan in its scanner's frame, or of
// all scans in the world's.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "engine/synthetic/scanner_pose.h"
#include "io/points/point_source.h"

namespace orbweave {

class RangeScans {
 public:
  virtual ~RangeScans() = default;
  RangeScans(const RangeScans&) = delete;
  RangeScans& operator=(const RangeScans&) = delete;

  int scans() const { return static_cast<int>(scans_.size()); }
  std::uint64_t points() const;
  std::uint64_t points(int scan) const { return scan_at(scan).row_first.back(); }
  const ScannerPose& pose(int scan) const { return scan_at(scan).pose; }
  /// Where the scanner of a scan is, in the scan's own frame; empty where it moves.
  const std::optional<ScannerPlace>& scanner(int scan) const { return scan_at(scan).scanner; }

  /// One scan in its own frame. This object has to outlive it. Uses the calling TBB arena.
  std::unique_ptr<PointSource> scan(int scan) const;
  /// All scans in world coordinates, one after the other, with a uint8 attribute `scan`: with
  /// float64 coordinates the same bits as pose(k).motion.point(p) of those of scan(k).
  std::unique_ptr<PointSource> all() const;

 protected:
  struct Scan {
    ScannerPose pose;
    std::optional<ScannerPlace> scanner;
    std::vector<std::uint64_t> row_first;  ///< index of each row's first point; and their number
  };

  explicit RangeScans(ScalarType precision) : precision_(precision) {}

  /// Writes the points of a row, in the scan's frame: as many as `row_first` says. A pure function,
  /// called by many threads.
  virtual void cast_row(std::size_t scan, std::size_t row, Vec3* out) const = 0;

  std::vector<Scan> scans_;

 private:
  class Source;
  const Scan& scan_at(int scan) const { return scans_.at(static_cast<std::size_t>(scan)); }

  ScalarType precision_;
};

}  // namespace orbweave
