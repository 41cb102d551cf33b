#include "engine/reconstruct.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "engine/ball_pivoting/surface_in_chunks.h"
#include "engine/holes/fill_mesh.h"
#include "engine/holes/small_pieces.h"
#include "engine/normals/estimate_normals.h"
#include "engine/normals/normal_side.h"
#include "engine/normals/orientation.h"
#include "engine/spacing/automatic_radii.h"
#include "engine/spacing/coordinate_decades.h"
#include "engine/spacing/normal_radius.h"
#include "engine/spacing/orientation_cell.h"
#include "engine/validation/usable_scale.h"
#include "io/cloud_columns.h"
#include "io/keep_points.h"
#include "io/points/point_views.h"
#include "io/text/counted_noun.h"
#include "io/text/quantity.h"
#include "partition/allowed_threads.h"
#include "partition/canonical_order.h"
#include "partition/cloud_counts.h"
#include "partition/point_filter.h"

namespace orbweave {
namespace {

constexpr int kMostLevels = 8;
constexpr int kLeastNeighbors = 3;
constexpr int kMostNeighbors = 256;
/// The walk over a chunk holds 180 bytes for each of its points; halos cost less than memory does.
constexpr std::uint64_t kChunkPoints = 500'000;

void require_range(const char* name, int value, int least, int most) {
  if (value >= least && value <= most) return;
  throw_usage(std::string(name) + " is out of range",
              {.found = std::to_string(value),
               .expected = std::to_string(least) + " to " + std::to_string(most)});
}

void require_limit(const char* name, double value) {
  if (value > 0.0) return;  // false for NaN
  throw_usage(std::string(name) + " is out of range",
              {.found = format_number(value), .expected = "a positive number"});
}

void check_fill(const FillOptions& options) {
  if (!(options.neighborhood >= 1.0) || !std::isfinite(options.neighborhood))
    throw_usage("fill.neighborhood is out of range", {.found = format_number(options.neighborhood),
                                                      .expected = "a number of at least 1"});
  if (options.max_diameter) require_limit("fill.max_diameter", *options.max_diameter);
  require_limit("fill.max_perimeter", options.max_perimeter);
}

void check_normals(const NormalOptions& options, bool has_scanners) {
  require_range("normals.neighbors", options.neighbors, kLeastNeighbors, kMostNeighbors);
  if (options.viewpoint && !is_finite(*options.viewpoint))
    throw_usage("normals.viewpoint is no place", {.expected = "three finite numbers"});
  if (options.up && (!is_finite(*options.up) || *options.up == Vec3{}))
    throw_usage("normals.up is no direction", {.expected = "three finite numbers, not all zero"});
  if (options.orientation == Orientation::kScanner && !has_scanners)
    throw_usage("points in memory do not say where they were scanned from",
                {.advice = "Give scanners or normals.viewpoint, or leave normals.orientation to "
                           "auto."});
  if (options.orientation == Orientation::kViewpoint && !options.viewpoint)
    throw_usage("the orientation towards a viewpoint needs normals.viewpoint");
}

void check_options(const ReconstructionOptions& options, std::size_t points) {
  require_range("levels", options.levels, 0, kMostLevels);
  check_fill(options.fill);
  check_normals(options.normals, !options.scanners.empty());
  if (!options.scanners.empty() && options.scanners.size() != points)
    throw_usage("the places of the scanners do not belong to the points",
                {.place = "scanners",
                 .found = counted_noun(options.scanners.size(), "place", "places"),
                 .expected = "as many as points, " + std::to_string(points)});
  if (options.threads < 0) throw_usage("threads is negative");
}

/// Tells the caller which stage begins, and stops where that is wanted.
class Stages {
 public:
  Stages(const ReconstructionOptions& options, int count) : options_(options), count_(count) {}

  void begin(std::string_view name) {
    check_stop(options_.stop);
    if (options_.progress)
      options_.progress(name, static_cast<double>(begun_) / static_cast<double>(count_));
    ++begun_;
  }

 private:
  const ReconstructionOptions& options_;
  int count_;
  int begun_ = 0;
};

/// What follows from the places of the points and the distances between them.
struct Spacing {
  RadiiChoice choice;
  double normal_radius = 0.0;
  Octree octree;
};

Spacing measure(std::span<const Vec3> positions, const PointCounts& counts, bool for_normals,
                const ReconstructionOptions& options) {
  require_usable_scale({}, "cloud", counts.bounds());
  const RootCube root = root_cube(counts.bounds());
  SpacingSampler sampler(root, counts);
  sampler.add(positions);
  sampler.merge_duplicates();
  Spacing spacing;
  spacing.octree = cut_octree(counts, root, kChunkPoints);
  require_few_decades(sampler.sites(), "");
  const SearchedSites sites(sampler.sites(), options.stop);
  const auto neighbors = static_cast<std::size_t>(options.normals.neighbors);
  const SampledNeighbors sample(sites, std::max(neighbors_for_radii(), for_normals ? neighbors : 0),
                                options.stop);
  spacing.choice = choose_radii(sample, sampler.cloud_points(), options.levels, options.stop);
  if (!for_normals) return spacing;
  spacing.normal_radius = normal_radius(
      sites, sample, std::max(neighbors, spacing.choice.line_neighbors), options.stop);
  return spacing;
}

/// The whole count of dropped points as text: "2 dropped: zero normal".
std::string describe(const DroppedPoints& dropped) {
  std::string text;
  for (const auto& [reason, count] : dropped)
    text += (text.empty() ? "" : ", ") + std::to_string(count) + " dropped: " + reason;
  return text;
}

void require_points(std::size_t points, const DroppedPoints& dropped) {
  if (points == 0) throw_bad_input("the cloud holds no usable point", {.found = describe(dropped)});
}

PointFilter first_filter(const ReconstructionOptions& options) {
  return options.keep_strays ? PointFilter() : measurement_filter({Vec3{}});
}

/// The filter that leaves out what the counted points bring to light; the same one: nothing more.
PointFilter next_filter(const PointFilter& filter, std::span<const std::uint64_t> at_scan_origins,
                        const PointCounts& counts, const ReconstructionOptions& options) {
  return options.keep_strays ? filter : narrowed(filter, at_scan_origins, counts);
}

/// Leaves out what is no measurement. The counts are of the points that stay.
CloudCounts count_measurements(PointCloud& cloud, const ReconstructionOptions& options,
                               DroppedPoints& dropped) {
  PointFilter filter = first_filter(options);
  for (;;) {
    const FilteredPoints filtered = drop_unusable(cloud, filter);
    for (const auto& [reason, count] : filtered.dropped) dropped[reason] += count;
    require_points(cloud.size(), dropped);
    CloudCounts counts(cloud.positions);
    PointFilter next = next_filter(filter, filtered.at_scan_origins, counts, options);
    if (next == filter) return counts;
    filter = std::move(next);
    check_stop(options.stop);
  }
}

void note_duplicates(std::uint64_t merged, DroppedPoints& dropped) {
  if (merged > 0) dropped[text_of(DropReason::kDuplicate)] += merged;
}

/// Normals as a file of that type holds them.
void round_normals(std::vector<Vec3>& normals, ScalarType type) {
  if (type != ScalarType::kFloat32) return;
  for (Vec3& normal : normals)
    for (int axis = 0; axis < 3; ++axis)
      normal[axis] = static_cast<double>(static_cast<float>(normal[axis]));
}

/// The direction that a point's normal should agree with; zero: the orientation decides later.
Vec3 wanted_side(Orientation side, const NormalOptions& options, const PointCloud& cloud,
                 std::size_t point) {
  if (side == Orientation::kUp) return options.up.value_or(Vec3{0.0, 0.0, 1.0});
  if (side == Orientation::kViewpoint) return *options.viewpoint - cloud.positions[point];
  if (side != Orientation::kScanner) return {};
  return direction_to_scanner(cloud, point, *view_offset(cloud.schema));
}

/// Whether the places of the scanners decide.
bool wants_views(bool estimates, const ReconstructionOptions& options) {
  return estimates && !options.scanners.empty() && asks_for_scanner(options.normals.orientation);
}

/// As readers of scans do it, so that a job on the same points has the same bytes.
void add_scanners(std::span<const Vec3> scanners, PointCloud& cloud) {
  std::vector<ViewCode> views(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3 direction = scanners[i] - cloud.positions[i];
    if (is_finite(direction)) views[i] = encode_view(direction);
  }
  add_views(views, cloud);
}

void require_scanners(std::uint64_t points_without_view) {
  if (points_without_view == 0) return;
  throw_bad_input("it is not known where some points were scanned from",
                  {.found = counted_points(points_without_view) + " without a scanner",
                   .expected = "a finite place for each point",
                   .advice = "Or leave normals.orientation to auto."});
}

/// Gives every point a normal; points that have too few neighbours for one are left out.
void estimate(PointCloud& cloud, double radius, Orientation side,
              const ReconstructionOptions& options, DroppedPoints& dropped) {
  const auto count = static_cast<std::uint32_t>(cloud.size());
  cloud.normals =
      estimate_normals(cloud.positions, 0, count,
                       {.neighbors = static_cast<std::size_t>(options.normals.neighbors),
                        .max_radius = radius,
                        .stop = options.stop})
          .normals;
  cloud.schema.has_normals = true;
  cloud.schema.normal_type = ScalarType::kFloat32;
  std::vector<std::uint8_t> kept(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    Vec3& normal = cloud.normals[i];
    kept[i] = normal == Vec3{} ? 0 : 1;
    if (dot(normal, wanted_side(side, options.normals, cloud, i)) < 0.0) normal = -normal;
  }
  keep_points(kept, cloud);
  if (cloud.size() != count) dropped[text_of(DropReason::kTooFewNeighbors)] += count - cloud.size();
  require_points(cloud.size(), dropped);
  round_normals(cloud.normals, cloud.schema.normal_type);
}

/// Turns the normals to one side by propagation.
void orient(PointCloud& cloud, const Spacing& spacing, Orientation side,
            const ReconstructionOptions& options) {
  const OrientationOptions wanted{.cell = orientation_cell(spacing.choice.spacing),
                                  .max_radius = spacing.normal_radius,
                                  .stop = options.stop,
                                  .among = spacing.choice.line_neighbors};
  std::vector<std::uint64_t> numbers(cloud.size());
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  OrientedPatches patches = orient_patches(cloud.positions, cloud.normals, numbers, 0,
                                           static_cast<std::uint32_t>(cloud.size()), wanted);
  const PatchOrientation orientation =
      orient_patch_graph(std::move(patches.sums), std::move(patches.votes),
                         graph_options(side, options.normals, wanted));
  const std::vector<std::uint8_t> turns =
      whole_turns(patches.patch_of, std::move(patches.turn), orientation);
  for (std::size_t i = 0; i < turns.size(); ++i)
    if (turns[i] != 0) cloud.normals[i] = -cloud.normals[i];
}

/// From a sorted cloud without normals to a sorted cloud with normals, and its spacing.
Spacing give_normals(PointCloud& cloud, const Spacing& spacing, Stages& stages,
                     const ReconstructionOptions& options, DroppedPoints& dropped) {
  const std::uint64_t without_view = count_without_view(cloud);
  const Orientation side = side_of_normals(options.normals, without_view);
  if (side == Orientation::kScanner) require_scanners(without_view);
  stages.begin("normals");
  estimate(cloud, spacing.normal_radius, side, options, dropped);
  drop_views(cloud);
  stages.begin("orient");
  if (is_propagated(side)) orient(cloud, spacing, side, options);
  // Points that were left out may have changed the bounds, and with them the order.
  const CloudCounts counts(cloud.positions);
  Spacing of_kept = measure(cloud.positions, counts, false, options);
  sort_canonically(cloud, of_kept.octree.root());
  return of_kept;
}

std::vector<double> usable_radii(const RadiiChoice& choice, const ReconstructionOptions& options) {
  if (options.ball_radii.empty()) {
    if (choice.radii.empty())
      throw_bad_input("no triangle can be formed: no ball radius can be chosen",
                      {.found = choice.reason});
    return choice.radii;
  }
  const double most = kMostSpacingsPerRadius * choice.spacing;
  if (choice.spacing > 0.0 && options.ball_radii.back() > most)
    throw_usage("the ball radius is too large",
                {.found = format_number(options.ball_radii.back()),
                 .expected = "at most " + format_number(most),
                 .advice = "Radii of one to five spacings close a surface."});
  return options.ball_radii;
}

/// Radii that were given, beside the distances that they are to bridge.
std::string given_radii_text(const std::vector<double>& radii, double spacing) {
  const std::string first = format_number(radii.front());
  return (radii.size() == 1 ? "ball radius " + first
                            : "ball radii " + first + " to " + format_number(radii.back())) +
         ", at a point spacing of " + format_number(spacing);
}

/// The mesh of a sorted cloud with normals.
Reconstruction surface_of(PointCloud cloud, Spacing spacing, Stages& stages,
                          const ReconstructionOptions& options, DroppedPoints dropped) {
  const RadiiChoice& choice = spacing.choice;
  Reconstruction result;
  result.dropped = std::move(dropped);
  result.ball_radii = usable_radii(choice, options);
  stages.begin("reconstruct");
  std::vector<Triangle> triangles = triangles_in_chunks(
      cloud.positions, cloud.normals, {.ball_radii = result.ball_radii, .stop = options.stop},
      std::move(spacing.octree));
  if (triangles.empty())
    throw_bad_input(
        "no triangle can be formed: no ball touches three points without holding a fourth, on the "
        "side their normals point to",
        {.found = options.ball_radii.empty() ? choice.reason
                                             : given_radii_text(options.ball_radii, choice.spacing),
         .expected = "points on a surface, normals that agree with it, and ball radii of about the "
                     "point spacing"});
  result.mesh = used_part(std::move(cloud), std::move(triangles));
  if (!options.fill.enabled) return result;
  stages.begin("fill");
  FilledMesh filled = fill_mesh(std::move(result.mesh), options.fill,
                                {.stop = options.stop,
                                 .has_point_normals = true,
                                 .drops_small_pieces = true,
                                 .takes_flaps = true});
  check_stop(options.stop);
  result.mesh = std::move(filled.mesh);
  result.holes = std::move(filled.holes);
  return result;
}

bool wants_estimate(bool has_normals, const NormalOptions& options) {
  if (options.source == NormalSource::kPoles)
    throw_usage(
        "poles are the normals of jobs alone",
        {.place = "normals.source", .found = "poles", .expected = "auto, file or estimate"});
  if (options.source == NormalSource::kFile && !has_normals)
    throw_bad_input("the cloud has no normals",
                    {.expected = "a normal per point",
                     .advice = "The sources auto and estimate estimate them."});
  return options.source == NormalSource::kEstimate || !has_normals;
}

Stages stages_of(bool estimates, const ReconstructionOptions& options) {
  return Stages(options, 3 + (estimates ? 2 : 0) + (options.fill.enabled ? 1 : 0));
}

/// From a sorted cloud to the result.
Reconstruction finish(PointCloud cloud, Spacing spacing, bool estimates, Stages& stages,
                      const ReconstructionOptions& options, DroppedPoints dropped) {
  if (estimates) spacing = give_normals(cloud, spacing, stages, options, dropped);
  round_normals(cloud.normals, cloud.schema.normal_type);
  return surface_of(std::move(cloud), std::move(spacing), stages, options, std::move(dropped));
}

Reconstruction reconstruct_cloud(PointCloud cloud, const ReconstructionOptions& options) {
  const bool estimates = wants_estimate(!cloud.normals.empty(), options.normals);
  if (estimates) cloud.normals = {};
  cloud.schema.has_normals = !cloud.normals.empty();
  if (wants_views(estimates, options)) add_scanners(options.scanners, cloud);
  Stages stages = stages_of(estimates, options);
  stages.begin("measure");
  DroppedPoints dropped;
  Spacing spacing;
  {
    const CloudCounts counts = count_measurements(cloud, options, dropped);
    spacing = measure(cloud.positions, counts, estimates, options);
  }
  stages.begin("sort");
  note_duplicates(sort_canonically(cloud, spacing.octree.root()), dropped);
  return finish(std::move(cloud), std::move(spacing), estimates, stages, options,
                std::move(dropped));
}

PointCloud copy_of(const PointColumns& columns) {
  PointCloud cloud;
  cloud.schema.has_normals = !columns.normals.empty();
  cloud.schema.normal_type = ScalarType::kFloat64;
  cloud.positions.assign(columns.positions.begin(), columns.positions.end());
  cloud.normals.assign(columns.normals.begin(), columns.normals.end());
  return cloud;
}

PointCloud rows_of(const PointColumns& columns, std::span<const std::uint32_t> rows) {
  PointCloud cloud;
  cloud.schema.has_normals = !columns.normals.empty();
  cloud.schema.normal_type = ScalarType::kFloat64;
  cloud.positions.reserve(rows.size());
  for (const std::uint32_t row : rows) cloud.positions.push_back(columns.positions[row]);
  if (!cloud.schema.has_normals) return cloud;
  cloud.normals.reserve(rows.size());
  for (const std::uint32_t row : rows) cloud.normals.push_back(columns.normals[row]);
  return cloud;
}

/// Counts where no point is to be left out; nothing otherwise.
std::optional<CloudCounts> counts_of_all(const PointColumns& columns,
                                         const ReconstructionOptions& options) {
  const PointFilter filter = first_filter(options);
  const FilteredPoints found = find_unusable(columns, filter);
  if (!found.dropped.empty() || columns.positions.empty()) return std::nullopt;
  std::optional<CloudCounts> counts(columns.positions);
  if (next_filter(filter, found.at_scan_origins, *counts, options) != filter) counts.reset();
  return counts;
}

Reconstruction reconstruct_columns(PointColumns columns, const ReconstructionOptions& options) {
  const bool estimates = wants_estimate(!columns.normals.empty(), options.normals);
  if (estimates) columns.normals = {};
  if (wants_views(estimates, options)) return reconstruct_cloud(copy_of(columns), options);
  std::optional<CloudCounts> counts = counts_of_all(columns, options);
  if (!counts) return reconstruct_cloud(copy_of(columns), options);
  Stages stages = stages_of(estimates, options);
  stages.begin("measure");
  Spacing spacing = measure(columns.positions, *counts, estimates, options);
  counts.reset();
  stages.begin("sort");
  PointCloud cloud = rows_of(columns, canonical_rows(columns, spacing.octree.root()));
  DroppedPoints dropped;
  note_duplicates(columns.positions.size() - cloud.size(), dropped);
  return finish(std::move(cloud), std::move(spacing), estimates, stages, options,
                std::move(dropped));
}

/// Runs on as many threads as the options say.
template <class Work>
Reconstruction on_threads(int threads, const Work& work) {
  if (threads == 0) return work();
  tbb::task_arena arena(allowed_threads(threads));
  return arena.execute(work);
}

}  // namespace

Reconstruction reconstruct(PointCloud cloud, const ReconstructionOptions& options) {
  check_options(options, cloud.size());
  check_columns(cloud);
  return on_threads(options.threads, [&] { return reconstruct_cloud(std::move(cloud), options); });
}

Reconstruction reconstruct(std::span<const Vec3> positions, std::span<const Vec3> normals,
                           const ReconstructionOptions& options) {
  check_options(options, positions.size());
  check_normal_count(normals.size(), positions.size());
  return on_threads(options.threads, [&] {
    return reconstruct_columns({positions, normals, {}, 0}, options);
  });
}

}  // namespace orbweave
