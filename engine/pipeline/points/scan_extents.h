// Where each scan of a job lies, and what is odd about that.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline/stage/resolved_job.h"
#include "engine/spacing/automatic_radii.h"
#include "io/box.h"
#include "io/points/point_source.h"

namespace orbweave {

struct ScanExtent {
  std::uint64_t points = 0;  ///< usable ones
  Box bounds;                ///< world coordinates
  std::optional<ScannerPlace> scanner;
};

/// The extents of all scans, as far as they are known.
class ScanExtents {
 public:
  /// Adds points of a scan.
  void add(ScanNumber scan, const ScanExtent& part);
  const std::map<ScanNumber, ScanExtent>& all() const { return of_scan_; }
  /// Which of all scans it is.
  std::uint32_t index_of(ScanNumber scan) const;

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

/// What scans_off_surface() finds in the places of the sampler, where that has collected the scans.
/// `meters_per_unit`: as the scans say.
std::vector<std::string> objections_to_surfaces(const ResolvedJob& job, const ScanExtents& extents,
                                                const SpacingSampler& sampler,
                                                std::optional<Vec3> meters_per_unit,
                                                const StopToken& stop);

}  // namespace orbweave
