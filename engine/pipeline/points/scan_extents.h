// Where each scan of a job lies, and what is odd about that.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "engine/pipeline/stage/resolved_job.h"
#include "io/box.h"
#include "io/points/point_source.h"

namespace orbweave {

struct ScanExtent {
  std::uint64_t points = 0;  ///< usable ones
  Box bounds;                ///< world coordinates
};

/// The extents of all scans, as far as they are known.
class ScanExtents {
 public:
  /// Adds points of a scan.
  void add(ScanNumber scan, const ScanExtent& part);
  const std::map<ScanNumber, ScanExtent>& all() const { return of_scan_; }

 private:
  std::map<ScanNumber, ScanExtent> of_scan_;
};

/// For a store; add_extents() takes what it gives.
std::string extents_text(const ScanExtents& extents);
void add_extents(const std::string& text, ScanExtents& extents);

/// "bun045.ply", or "scan 3 of site.e57" where the file holds several of the scans.
std::string name_of_scan(const ResolvedJob& job, const ScanExtents& extents, ScanNumber scan);

/// What odd_scans() finds, a sentence each: scans that probably are in another unit, or counted
/// from another origin.
std::vector<std::string> objections_to_extents(const ResolvedJob& job, const ScanExtents& extents);

}  // namespace orbweave
