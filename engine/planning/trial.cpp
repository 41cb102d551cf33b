#include "engine/planning/trial.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "engine/cleaning/outliers.h"
#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "engine/reconstruct.h"
#include "engine/spacing/automatic_radii.h"
#include "io/error.h"
#include "io/system/process_times.h"
#include "partition/allowed_threads.h"
#include "partition/canonical_order.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kSamples = 8;
constexpr std::uint64_t kSamplePoints = 16'384;
/// Where the grid does not resolve a dense place, its leaf holds any number.
constexpr std::size_t kMostSamplePoints = 2 * kSamplePoints;

std::uint32_t count_of(const PointCloud& cloud) { return static_cast<std::uint32_t>(cloud.size()); }

void drop_outliers(PointCloud& cloud, const TrialOptions& options) {
  std::vector<std::uint8_t> flags = find_outliers(cloud.positions, 0, count_of(cloud),
                                                  {.sigma = options.cleaning.outlier_sigma,
                                                   .max_radius = options.reach_of_outliers,
                                                   .stop = options.stop});
  for (std::uint8_t& flag : flags) flag ^= 1;
  cloud = kept_points(std::move(cloud), flags);
}

/// Normals for the smoothing, of either sign.
void estimate(PointCloud& cloud, const TrialOptions& options) {
  NormalEstimateOptions estimate = options.estimate;
  estimate.stop = options.stop;
  cloud.normals = estimate_normals(cloud.positions, 0, count_of(cloud), estimate).normals;
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = ScalarType::kFloat64;
}

/// `chosen`: as for project_points.
void project(PointCloud& cloud, const TrialOptions& options,
             std::span<const std::uint8_t> chosen = {}) {
  ProjectedPoints moved = project_points(cloud.positions, cloud.normals, 0, count_of(cloud),
                                         {.radius = options.cleaning.smooth_radius,
                                          .oriented = !options.estimates_normals,
                                          .stop = options.stop},
                                         chosen);
  cloud.positions = std::move(moved.positions);
  cloud.normals = std::move(moved.normals);
}

/// Which points stay. The trial takes merging for thinning: both cost the same.
std::vector<std::uint8_t> thinned(const PointCloud& cloud, double spacing,
                                  const TrialOptions& options) {
  return thin_points(cloud.positions, {}, 0, count_of(cloud),
                     {.spacing = spacing, .min_cosine = -1.0, .stop = options.stop});
}

/// The last projection is for the points that thinning keeps alone, as in the job.
void smooth_and_thin(PointCloud& cloud, const TrialOptions& options) {
  const CleaningOptions& cleaning = options.cleaning;
  const bool thins = cleaning.thin_to_spacing > 0.0;
  if (options.estimates_normals) estimate(cloud, options);
  for (Vec3& normal : cloud.normals) normal = normalized(normal);
  for (int pass = thins ? 1 : 0; pass < cleaning.smooth_passes; ++pass) project(cloud, options);
  if (!thins) return;
  const std::vector<std::uint8_t> kept = thinned(cloud, cleaning.thin_to_spacing, options);
  project(cloud, options, kept);
  cloud = kept_points(std::move(cloud), kept);
}

void thin(PointCloud& cloud, double spacing, const TrialOptions& options) {
  const std::vector<std::uint8_t> kept = thinned(cloud, spacing, options);
  cloud = kept_points(std::move(cloud), kept);
}

void clean(PointCloud& cloud, const TrialOptions& options) {
  const CleaningOptions& cleaning = options.cleaning;
  if (cleaning.outlier_sigma > 0.0) drop_outliers(cloud, options);
  if (cleaning.merge_tolerance > 0.0) thin(cloud, cleaning.merge_tolerance, options);
  if (cleaning.smooth_radius > 0.0)
    smooth_and_thin(cloud, options);
  else if (cleaning.thin_to_spacing > 0.0)
    thin(cloud, cleaning.thin_to_spacing, options);
}

ReconstructionOptions surface_options(const TrialOptions& options) {
  ReconstructionOptions surface;
  surface.ball_radii = options.ball_radii;
  surface.normals = options.normals;
  if (options.estimates_normals) surface.normals.source = NormalSource::kEstimate;
  // Points in memory have no scanner.
  if (surface.normals.orientation == Orientation::kScanner)
    surface.normals.orientation = Orientation::kPropagate;
  surface.fill = options.fill;
  surface.fill.keep_outer_border = true;
  surface.keep_strays = true;
  surface.stop = options.stop;
  return surface;
}

/// Radii for a cleaned sample. The sparse parts of the whole cloud ask for them where the sample
/// itself is even.
std::vector<double> chosen_radii(const PointCloud& cloud, const TrialOptions& options) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  constexpr std::size_t kMostRadii = 8;
  const Box everything{{-kFar, -kFar, -kFar}, {kFar, kFar, kFar}};
  const SpacingSite whole{everything, everything, cloud.positions};
  const SearchedSites sites(std::span(&whole, 1), options.stop);
  std::vector<double> radii =
      choose_radii(SampledNeighbors(sites, neighbors_for_radii(), options.stop), cloud.size(), 0,
                   options.stop)
          .radii;
  while (!radii.empty() && radii.size() < kMostRadii && radii.back() < options.least_last_radius)
    radii.push_back(kRadiusGrowth * radii.back());
  return radii;
}

/// Returns the number of points after cleaning.
std::uint64_t run_on_sample(PointCloud cloud, const TrialOptions& options) {
  cloud.attributes.clear();
  cloud.schema.attributes.clear();
  try {
    sort_canonically(cloud, root_cube(cloud.bounds()));
    clean(cloud, options);
    const std::uint64_t kept = cloud.size();
    ReconstructionOptions surface = surface_options(options);
    if (surface.ball_radii.empty() && options.least_last_radius > 0.0)
      surface.ball_radii = chosen_radii(cloud, options);
    static_cast<void>(reconstruct(std::move(cloud), surface));
    return kept;
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::kInterrupted) throw;
    return 0;
  }
}

}  // namespace

TrialSamples::TrialSamples(const RootCube& root, const PointCounts& grid) : root_(root) {
  const std::vector<Chunk> leaves = cut_octree(grid, root, kSamplePoints).chunks();
  std::uint64_t before = 0, next = 0;
  for (const Chunk& leaf : leaves) {
    // The middles of kSamples equal parts of the cloud, in the order of the leaves.
    const std::uint64_t end = before + leaf.points;
    const std::uint64_t place = (2 * next + 1) * grid.points() / (2 * kSamples);
    if (place < end && next < kSamples) samples_.push_back({leaf.code_begin, leaf.code_end, {}});
    while (next < kSamples && (2 * next + 1) * grid.points() / (2 * kSamples) < end) ++next;
    before = end;
  }
}

void TrialSamples::add(const PointCloud& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::uint64_t code = morton_code(points.positions[i], root_);
    const auto after =
        std::upper_bound(samples_.begin(), samples_.end(), code,
                         [](std::uint64_t c, const Sample& p) { return c < p.code_begin; });
    if (after == samples_.begin() || code >= std::prev(after)->code_end) continue;
    PointCloud& sample = std::prev(after)->points;
    if (sample.size() >= kMostSamplePoints) continue;
    if (sample.empty()) sample.schema = points.schema;
    sample.append(points, i);
  }
}

std::vector<PointCloud> TrialSamples::take() {
  constexpr std::size_t kLeastPoints = 3;
  std::vector<PointCloud> result;
  for (Sample& sample : samples_)
    if (sample.points.size() >= kLeastPoints) result.push_back(std::move(sample.points));
  return result;
}

TrialResult run_trial(std::vector<PointCloud> samples, const TrialOptions& options) {
  TrialResult result;
  for (const PointCloud& sample : samples) result.points += sample.size();
  std::vector<std::uint64_t> kept(samples.size(), 0);
  const double begin = process_cpu_seconds();
  tbb::task_arena arena(allowed_threads(options.threads));
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, samples.size(), [&](std::size_t i) {
      kept[i] = run_on_sample(std::move(samples[i]), options);
    });
  });
  result.cpu_seconds = process_cpu_seconds() - begin;
  for (const std::uint64_t points : kept) result.points_kept += points;
  return result;
}

}  // namespace orbweave
