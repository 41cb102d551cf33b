// A job with what its inputs say. Resolving looks at every input once; keys, forecasts and plans
// are functions of the result and open no file.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/job/job.h"
#include "io/report/report.h"
#include "partition/memory_plan.h"

namespace orbweave {

/// What tells an input from a later file of the same name.
struct InputStamp {
  std::string file;
  std::uint64_t bytes = 0;
  std::string modified;               ///< time of the last change, UTC; empty: unknown
  std::optional<std::string> sample;  ///< fingerprint of a part of the content
  std::uint64_t bytes_hashed = 0;     ///< of the content, for the sample
  std::string problem;                ///< why nothing is known of the file; empty: it is

  /// "5 bytes of 2026-01-01T00:00:00.000000000Z, sample 0123"
  std::string text() const;
};

/// Looks at a file now; `blocks`: as for sample_file.
InputStamp stamp_of(const std::string& file, std::size_t blocks);

struct ResolvedJob : Job {
  std::vector<std::string> files;  ///< scans, patterns expanded
  std::vector<InputStamp> inputs;  ///< scans and other files, as they were when resolved
  bool estimates_normals = false;  ///< false: the normals of the files are used
  std::vector<ScanPose> poses;     ///< of the scans, as the job and the file of poses have them
  std::shared_ptr<const PolygonArea> area;       ///< of input.crop_area; null: none
  std::shared_ptr<const Trajectory> trajectory;  ///< null: none
  std::string beside_scans;  ///< what lies beside the scans, for keys; empty: nothing

  int threads() const;
  /// Whether any stage of the cleaning is on; automatic cleaning may turn more on.
  bool cleans() const;
  /// Whether raw points pass through cleaning or the estimation of normals.
  bool needs_cleaning_or_normals() const;
  /// Whether points carry the direction to their scanner.
  bool wants_view() const;
  /// The rule for the side of estimated normals: the first that applies.
  Orientation orientation_rule(std::uint64_t points_without_view) const;
  /// How the memory budget is spent on `points` points. Throws as plan_memory.
  MemoryPlan memory_plan(std::uint64_t points, const PointSchema& schema,
                         std::uint64_t worthwhile_points = 0) const;
};

/// Looks at the inputs; `files`: the job's scans, patterns expanded. Throws Error (bad input) where
/// a scan is a pipe, one cannot be opened to see whether it has normals, or the poses or the
/// trajectory cannot be read; Error (usage) where two keys say where the scanner was.
ResolvedJob resolve(const Job& job, std::vector<std::string> files);

/// The inputs as they are now.
std::vector<InputStamp> stamps_of_inputs(const ResolvedJob& job);

/// What the report says of the inputs. A pipe is left out: nothing is known of it.
std::vector<TrustedFile> trusted_files(const ResolvedJob& job);

/// Whether any stage of the cleaning is on.
bool cleans(const CleaningOptions& options);

/// The work directory of a job: as named, else beside the mesh with its name.
std::string work_dir_of(const Job& job);

/// The leader's log in the work directory.
inline constexpr const char* kLogName = "orbweave.log";

}  // namespace orbweave
