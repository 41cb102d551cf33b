// What a run would do and need, from two passes over its scans and a trial on samples of them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/box.h"
#include "io/hole_facts.h"
#include "io/job/job.h"
#include "io/report/progress.h"
#include "io/report/report.h"
#include "io/stop_token.h"

namespace orbweave {

/// What a run would do. Writes nothing.
struct JobPlan {
  std::vector<std::string> files;
  std::uint64_t points = 0;                             ///< that are selected and usable
  std::uint64_t points_read = 0;                        ///< that the scans hold
  std::map<std::string, std::uint64_t> points_dropped;  ///< by reason
  Box bounds;
  std::uint64_t chunks = 0;
  std::uint64_t chunk_points = 0;  ///< the limit that the octree was cut with
  std::uint64_t largest_chunk_points = 0;
  double halo_width = 0.0;
  std::vector<double> radii;
  std::string radii_note;    ///< radii and spacing, for one line
  std::string radii_reason;  ///< radii are those of the raw points where these are cleaned
  CleaningFacts cleaning;    ///< the cleaning; all options 0: none
  std::string noise_note;    ///< noise of the scans, for one line; empty: not measured
  /// What is doubtful about the scans, a sentence each; a run warns of it.
  std::vector<std::string> doubts;
  NormalFacts normals;  ///< source and orientation
  int chunks_in_flight = 0;
  std::uint64_t peak_memory_bytes = 0;  ///< predicted
  std::uint64_t disk_bytes = 0;         ///< predicted: work directory and output
  double seconds = 0.0;                 ///< predicted, by a trial on samples of the cloud
  /// Boundary loops, where the work directory holds the meshes of all chunks of this very job
  /// (`reason` says why where one would stay open); empty: not known before the reconstruction.
  std::optional<std::vector<HoleFacts>> loops;
};
JobPlan plan_job(const Job& job, Progress& progress, const StopToken& stop);

}  // namespace orbweave
