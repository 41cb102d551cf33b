// A trial: what a job does to points, done to small samples of its cloud, for the time that it
// takes there. Rates in a table know neither the machine nor the noise, nor how many points stay
// open at the first ball radius.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/normals/estimate_normals.h"
#include "io/job/job.h"
#include "io/point_cloud.h"
#include "io/report/report_facts.h"
#include "io/stop_token.h"
#include "partition/octree.h"

namespace orbweave {

/// Collects samples while a cloud streams by: cubes of an octree with the points in them.
class TrialSamples {
 public:
  /// Eight leaves of at most 16,384 points, as far as the grid resolves, at even distances along
  /// the order of the points. `grid` holds the whole cloud and is settled. The choice depends on
  /// the cloud as a set.
  TrialSamples(const RootCube& root, const PointCounts& grid);

  /// Every point of the cloud is added once. A sample takes 32,768 points at most. Not thread-safe.
  void add(const PointCloud& points);
  /// Samples of three points and more.
  std::vector<PointCloud> take();

 private:
  struct Sample {
    std::uint64_t code_begin = 0;
    std::uint64_t code_end = 0;
    PointCloud points;
  };
  RootCube root_;
  std::vector<Sample> samples_;  ///< in the order of their codes
};

/// The options of a job as they are applied to points in memory.
struct TrialOptions {
  CleaningOptions cleaning;
  NormalOptions normals;
  bool estimates_normals = false;
  NormalEstimateOptions estimate;  ///< before smoothing; not used where normals are given
  double reach_of_outliers = 0.0;  ///< neighbours that count; world units
  std::vector<double> ball_radii;  ///< empty: chosen from each sample, as after a thinning
  /// Of radii that are chosen: they grow until the last is no smaller. A sample has fewer densities
  /// than its cloud, and would end sooner. World units; 0: as the sample asks.
  double least_last_radius = 0.0;
  FillOptions fill;                 ///< the outer border of a sample stays open
  int threads = 1;                  ///< samples that are worked on at a time
  const StopToken* stop = nullptr;  ///< may be null
};

struct TrialResult {
  double cpu_seconds = 0.0;       ///< of all threads
  std::uint64_t points = 0;       ///< that the samples held
  std::uint64_t points_kept = 0;  ///< of these, after cleaning
};

/// Cleans, estimates, reconstructs and fills each sample by itself. A sample that has no triangle
/// counts with the time that finding out took. Throws Error (interrupted) alone.
TrialResult run_trial(std::vector<PointCloud> samples, const TrialOptions& options);

}  // namespace orbweave
