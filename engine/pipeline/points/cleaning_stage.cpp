#include "engine/pipeline/points/cleaning_stage.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <utility>

#include "engine/cleaning/clusters.h"
#include "engine/cleaning/outliers.h"
#include "engine/cleaning/thinning.h"
#include "engine/normals/estimate_normals.h"
#include "engine/normals/normal_side.h"
#include "engine/pipeline/points/cleaned_source.h"
#include "engine/pipeline/points/local_measures.h"
#include "engine/pipeline/points/noise_stage.h"
#include "engine/pipeline/points/orientation_stage.h"
#include "engine/pipeline/points/orientation_words.h"
#include "engine/pipeline/points/point_doubts.h"
#include "engine/pipeline/points/quality_pass.h"
#include "engine/pipeline/points/raw_passes.h"
#include "engine/pipeline/points/scan_input.h"
#include "engine/pipeline/points/smoothing_passes.h"
#include "engine/pipeline/stage/cleaning_rule.h"
#include "engine/pipeline/stage/scan_units.h"
#include "engine/pipeline/stage/stage_begin.h"
#include "engine/pipeline/stage/stage_keys.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "engine/spacing/layer_thickness.h"
#include "engine/spacing/site_points.h"
#include "io/error.h"
#include "io/job/job_keys.h"
#include "io/job/setting.h"
#include "io/points/point_views.h"
#include "io/report/reasons.h"
#include "io/store/chunk_points.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

/// Neighbours that tell whether noisy layers are a surface.
constexpr std::size_t kNeighborsInLayers = 256;

/// Says what was measured, and what follows from it or would have followed.
CleaningFacts describe_layers(StageRunner& runner, const Partition& scans) {
  CleaningFacts facts = cleaning_for(runner.job.cleaning, scans);
  const double unit = meters_per_unit(runner.job, scans);
  const bool acts_on_noise =
      facts.options.smooth_radius > 0.0 || facts.options.thin_to_spacing > 0.0;
  if (runner.job.cleaning.automatic) {
    runner.say_of_points(
        {"cleaning: " + short_reason(scans.layers, unit), "cleaning: " + facts.reason});
  } else if (!acts_on_noise && scans.layers.is_thick()) {
    runner.say_of_points({.shown = short_noise(scans.layers, unit) +
                                   ": the mesh may be rough or have holes; try " +
                                   setting(runner.job, "cleaning.auto", "true"),
                          .full = "the mesh may be rough or have holes: " + facts.reason,
                          .is_warning = true});
  }
  return facts;
}

/// Doubt is worth a warning where it is about so many places. (Real scans: under 2 %.)
constexpr double kManyPlaces = 0.2;

/// Two sheets that smoothing makes one of, or leaves apart. Where layers are thick on
/// the whole and nothing acts on that, describe_layers() warns of them.
void warn_of_double_layers(StageRunner& runner, const Partition& scans,
                           const CleaningFacts& facts) {
  const LayerThickness& layers = scans.layers;
  if (layers.double_share < kManyPlaces) return;
  const bool smooths = facts.options.smooth_radius > 0.0;
  if (!smooths && layers.is_thick()) return;
  const Length gap = readable_length(layers.gap, meters_per_unit(runner.job, scans));
  const std::string where = "the points lie in two layers about " + short_text(gap.value) +
                            gap.unit + " apart at " + format_percent(layers.double_share) +
                            " of the places, and ";
  const std::string part = facts.is_local
                               ? " at the " + format_percent(1.0 - facts.untouched_share) +
                                     " of the places that it smooths"
                               : "";
  const std::string what =
      smooths ? where + "cleaning makes one of them" + part +
                    ": right where scans do not lie on each other, wrong for the two sides of a "
                    "plate"
              : where +
                    "no smoothing makes one of them: right for the two sides of a plate, wrong "
                    "where scans "
                    "do not lie on each other";
  const std::string advice = smooths ? "; of a plate, take " +
                                           setting(runner.job, "cleaning.auto", "false") +
                                           " and no other smoothing; of scans, register them better"
                                     : "; of scans, register them better";
  runner.say_of_points({.shown = what, .full = what + advice, .is_warning = true});
}

/// The same points twice, with a little between them, are no noise, and no even surface either.
void warn_of_twins(StageRunner& runner, const Partition& scans, const CleaningFacts& facts) {
  constexpr double kApart = 0.1;  // of the spacing: what thinning takes
  const LayerThickness& layers = scans.layers;
  const double apart = kApart * layers.spacing;
  const bool is_mended =
      facts.options.merge_tolerance >= 0.5 * apart || facts.options.thin_to_spacing >= 0.5 * apart;
  if (layers.twin_share < kManyPlaces || is_mended) return;
  const std::string what = format_percent(layers.twin_share) +
                           " of the points have another one closer than a twentieth of the point "
                           "spacing, as if scans came twice: the mesh may have holes and flipped "
                           "parts; try " +
                           setting(runner.job, "cleaning.thin_to_spacing", short_text(apart));
  runner.say_of_points({.shown = what, .full = what, .is_warning = true});
}

void warn_of_steps(StageRunner& runner, const Partition& scans, const CleaningFacts& facts) {
  const std::string objection = objection_to_steps(runner.job, scans, facts.options);
  if (!objection.empty()) runner.say_of_points({objection, objection, true});
}

std::vector<std::uint8_t> turned(std::vector<std::uint8_t> flags) {
  for (std::uint8_t& flag : flags) flag ^= 1;
  return flags;
}

/// 1 for each of the chunk's own points that is no outlier. Clusters may have a wider halo.
std::vector<std::uint8_t> inliers(const PassPoints& points, const OutlierOptions& options) {
  const Box reach = points.own.bounds().grown(outlier_halo(options));
  const auto is_near = [&](Vec3 p) { return reach.contains(p); };
  if (std::all_of(points.positions.begin(), points.positions.end(), is_near))
    return turned(find_outliers(points.positions, points.begin, points.end, options));
  std::vector<Vec3> positions;
  positions.reserve(points.positions.size());
  std::uint32_t begin = 0, end = 0;
  for (std::uint32_t i = 0; i < points.positions.size(); ++i) {
    if (i == points.begin) begin = static_cast<std::uint32_t>(positions.size());
    if (i == points.end) end = static_cast<std::uint32_t>(positions.size());
    if (is_near(points.positions[i])) positions.push_back(points.positions[i]);
  }
  if (points.end == points.positions.size()) end = static_cast<std::uint32_t>(positions.size());
  return turned(find_outliers(positions, begin, end, options));
}

/// Outliers and small clusters, in one pass: both are what the points as they came tell.
RawPass stray_pass(const StageRunner& runner, const CleaningOptions& options,
                   const RawCloud& cloud) {
  const OutlierOptions outliers{.sigma = options.outlier_sigma,
                                .max_radius = cloud.partition.normal_radius,
                                .stop = &runner.stop};
  const ClusterOptions clusters{.points = options.cluster_points.value_or(0),
                                .gap = cloud.partition.normal_radius,
                                .stop = &runner.stop};
  return {
      .stage = directory_of(Stage::kOutliers),
      .options =
          key_line(stored_key_name("cleaning.outlier_sigma"), format_exact(outliers.sigma)) +
          key_line(stored_key_name("cleaning.cluster_points"), std::to_string(clusters.points)) +
          key_line("reach of outliers", format_exact(outliers.max_radius)),
      .halo = std::max(outliers.sigma > 0.0 ? outlier_halo(outliers) : 0.0,
                       clusters.points > 0 ? cluster_halo(clusters) : 0.0),
      .dropped_reason = DropReason::kOutlier,
      .also_reason = DropReason::kCluster,
      .work = [outliers, clusters](PassPoints&& points) {
        std::vector<std::uint8_t> kept(points.own.size(), 1);
        PassResult result;
        if (outliers.sigma > 0.0) kept = inliers(points, outliers);
        if (clusters.points > 0) {
          const auto found = find_clusters(points.positions, points.begin, points.end, clusters);
          for (std::size_t i = 0; i < kept.size(); ++i) {
            if (kept[i] == 0 || found[i] == 0) continue;
            kept[i] = 0;
            ++result.also_dropped;
          }
        }
        result.points = kept_points(std::move(points.own), kept);
        return result;
      }};
}

RawPass merge_pass(const StageRunner& runner, const CleaningOptions& options) {
  const ThinningOptions merging{options.merge_tolerance, kSameSheetCosine, &runner.stop};
  return {.stage = directory_of(Stage::kMerging),
          .options =
              key_line(stored_key_name("cleaning.merge_tolerance"), format_exact(merging.spacing)),
          .halo = merging_halo(merging),
          .drift = merging.spacing,
          .dropped_reason = DropReason::kMerged,
          .work = [merging](PassPoints&& points) {
            MergedPoints merged =
                merge_points(points.positions, points.normals, points.begin, points.end, merging);
            add_moves(points.own, merged.positions);
            points.own.positions = std::move(merged.positions);
            if (!merged.normals.empty()) points.own.normals = std::move(merged.normals);
            return PassResult{kept_points(std::move(points.own), merged.kept)};
          }};
}

/// Neighbourhoods as wide as those that smoothing looks at.
RawPass surfaceness_pass(const StageRunner& runner, const CleaningOptions& options,
                         const LocalCleaning& cleaning, const RawCloud& cloud) {
  std::vector<SurfacenessOptions> of_level;
  for (const double radius : cleaning.radii) {
    SurfacenessOptions one{.max_radius = cloud.partition.normal_radius, .stop = &runner.stop};
    if (radius > 0.0) one = {kNeighborsInLayers, std::max(one.max_radius, radius), &runner.stop};
    of_level.push_back(one);
  }
  const double least = options.min_surfaceness;
  return {.stage = directory_of(Stage::kSurfaceness),
          .options = key_line(stored_key_name("cleaning.min_surfaceness"), format_exact(least)) +
                     key_line("places of surfaceness", cleaning.key()) +
                     key_line("reach of surfaceness", format_exact(of_level.back().max_radius)),
          .halo = of_level.back().max_radius,
          .dropped_reason = DropReason::kNoSurface,
          .work = [cleaning, of_level, least](PassPoints&& points) {
            const auto levels = cleaning.levels_of(points.positions);
            std::vector<std::uint8_t> kept;
            for (const float one : surfaceness_locally(points, levels, of_level))
              kept.push_back(one >= least ? 1 : 0);
            return PassResult{kept_points(std::move(points.own), kept)};
          }};
}

/// What decides the side of estimated normals.
struct SideRule {
  Orientation by = Orientation::kNone;
  Vec3 vector;  ///< viewpoint or direction

  /// Direction that the normal of point i should agree with; zero: no matter.
  Vec3 wanted(const PointCloud& points, std::size_t i, std::optional<std::size_t> view) const {
    if (by == Orientation::kUp) return vector;
    if (by == Orientation::kViewpoint) return vector - points.positions[i];
    if (by != Orientation::kScanner || !view) return {};
    return direction_to_scanner(points, i, *view);
  }
};

std::string text_of(const SideRule& rule) {
  return std::string(text_of(rule.by)) + " " + format_exact(rule.vector.x) + " " +
         format_exact(rule.vector.y) + " " + format_exact(rule.vector.z);
}

/// The first that applies: scanner, viewpoint, up, propagation.
SideRule side_rule(const StageRunner& runner, const RawCloud& cloud) {
  const NormalOptions& options = runner.job.normals;
  check_side(runner.job, cloud.partition.points_without_view);
  SideRule rule{runner.job.orientation_rule(cloud.partition.points_without_view), {}};
  if (rule.by == Orientation::kViewpoint) rule.vector = options.viewpoint.value();
  if (rule.by == Orientation::kUp) rule.vector = options.up.value_or(Vec3{0.0, 0.0, 1.0});
  return rule;
}

/// The normals of the chunk's own points, or none where there is none.
PointCloud with_normals(PassPoints&& points, std::vector<Vec3> normals, const SideRule& rule) {
  const std::optional<std::size_t> view = view_offset(points.own.schema);
  std::vector<std::uint8_t> kept(points.own.size());
  for (std::size_t i = 0; i < points.own.size(); ++i) {
    kept[i] = normals[i] == Vec3{} ? 0 : 1;
    if (dot(normals[i], rule.wanted(points.own, i, view)) < 0.0) normals[i] = -normals[i];
  }
  points.own.normals = std::move(normals);
  return kept_points(std::move(points.own), kept);
}

/// `untouched`: the level whose options points have that are not to be moved.
RawPass normal_pass(const LocalCleaning& cleaning,
                    const std::vector<NormalEstimateOptions>& options, std::uint8_t untouched,
                    const SideRule& rule) {
  std::string key = key_line("normals.neighbors", std::to_string(options.back().neighbors)) +
                    key_line("places of normals", cleaning.key()) +
                    key_line("normals of thin layers", std::to_string(untouched));
  for (const NormalEstimateOptions& one : options)
    key += key_line("reach of normals", format_exact(one.max_radius)) +
           key_line("cubes of normals", format_exact(one.shared_side));
  return {.stage = directory_of(Stage::kNormals),
          .options = key + key_line("normals.orientation", text_of(rule)),
          .halo = local_normal_halo(options),
          .adds_normals = true,
          .dropped_reason = DropReason::kTooFewNeighbors,
          .work = [cleaning, options, untouched, rule](PassPoints&& points) {
            std::vector<std::uint8_t> levels = cleaning.levels_of(points.positions);
            std::replace(levels.begin(), levels.end(), std::uint8_t{0}, untouched);
            std::vector<Vec3> normals = normals_locally(points, levels, options);
            return PassResult{with_normals(std::move(points), std::move(normals), rule)};
          }};
}

/// Of all points, which are one chunk: the cells of a part of them are not those of the cloud.
RawPass pole_pass(const StageRunner& runner, const SideRule& rule) {
  return {.stage = directory_of(Stage::kNormals),
          .options = key_line("normals", "poles") + key_line("normals.orientation", text_of(rule)),
          .adds_normals = true,
          .dropped_reason = DropReason::kTooFewNeighbors,
          .work = [&runner, rule](PassPoints&& points) {
            std::vector<Vec3> normals =
                normals_from_poles(runner.job, points.positions, &runner.stop);
            return PassResult{with_normals(std::move(points), std::move(normals), rule)};
          }};
}

NormalFacts take_poles(StageRunner& runner, RawCloud& cloud) {
  const SideRule rule = side_rule(runner, cloud);
  run_pass(runner, pole_pass(runner, rule), cloud);
  NormalFacts normals;
  normals.source = NormalSource::kPoles;
  normals.orientation = rule.by;
  return normals;
}

/// The raw points in chunks; resumes from the store where it holds them whole.
CutPoints raw_points(StageRunner& runner) {
  if (std::optional<Partition> stored =
          begin_partition(runner, kRawCut, raw_points_key(runner.job))) {
    for (const SaidLine& line : stored->said) runner.say_of_points(line);
    return {std::move(*stored), 0};
  }
  return partition_by_team(runner, kRawCut,
                           [&] { return cut_and_sort(scans_as_input(runner, kRawCut), runner); });
}

/// How many of a chunk's points were moved, and how far together.
std::string moves_document(ChunkId chunk) { return "moves_" + std::to_string(chunk); }

/// Measures the moves of a chunk's points from the stage `before`, of which a pass leaves all, or
/// those that its rows name.
void measure_moves(const StageRunner& runner, const std::string& before, const PointSchema& schema,
                   const std::string& stage, ChunkId chunk, const PassResult& after) {
  const PointCloud from = load_points(runner.store, chunk, schema, before);
  double sum = 0.0;
  std::uint64_t moved = 0;
  for (std::size_t i = 0; i < after.points.size(); ++i) {
    const Vec3 was = from.positions[after.rows.empty() ? i : after.rows[i]];
    if (was == after.points.positions[i]) continue;
    sum += norm(after.points.positions[i] - was);
    ++moved;
  }
  runner.store.commit_document(stage, moves_document(chunk),
                               nlohmann::json::array({moved, sum}).dump());
}

/// Adds up the moves of all chunks of the latest pass.
void take_moves(const StageRunner& runner, const RawCloud& cloud, CleaningFacts& facts) {
  double sum = 0.0;
  std::uint64_t moved = 0;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk) {
    const auto stored = runner.store.document(cloud.stage, moves_document(chunk));
    if (!stored) continue;
    const nlohmann::json moves = nlohmann::json::parse(*stored);
    moved += moves.at(0).get<std::uint64_t>();
    sum += moves.at(1).get<double>();
  }
  facts.points_moved = moved;
  facts.mean_move = moved == 0 ? 0.0 : sum / static_cast<double>(moved);
}

/// What decides the side of the normals, for the quality of vertices.
NormalOrigin normal_origin(const StageRunner& runner, const RawCloud& cloud) {
  if (!runner.job.estimates_normals) return NormalOrigin::kGiven;
  switch (side_rule(runner, cloud).by) {
    case Orientation::kScanner:
      return NormalOrigin::kScanner;
    case Orientation::kViewpoint:
      return NormalOrigin::kViewpoint;
    case Orientation::kUp:
      return NormalOrigin::kUp;
    case Orientation::kPropagate:
      return NormalOrigin::kPropagated;
    case Orientation::kGround:
      return NormalOrigin::kGround;
    case Orientation::kInward:
      return NormalOrigin::kInward;
    default:
      return NormalOrigin::kNoSide;
  }
}

void drop_and_merge(StageRunner& runner, const CleaningOptions& cleaning,
                    const LocalCleaning& local, RawCloud& cloud) {
  const bool has_reach = cloud.partition.normal_radius > 0.0;
  if (cleaning.outlier_sigma > 0.0 || (cleaning.cluster_points.value_or(0) > 0 && has_reach))
    run_pass(runner, stray_pass(runner, cleaning, cloud), cloud);
  if (cleaning.merge_tolerance > 0.0) run_pass(runner, merge_pass(runner, cleaning), cloud);
  if (cleaning.min_surfaceness > 0.0 && has_reach)
    run_pass(runner, surfaceness_pass(runner, cleaning, local, cloud), cloud);
}

/// Where layers are thick on the whole, thin ones among them have normals as all have, which costs
/// less: those of points that share a cube. Elsewhere each has its own.
std::uint8_t level_of_untouched(const CleaningOptions& cleaning, const LocalCleaning& local,
                                const RawCloud& cloud) {
  const auto whole = std::find(local.radii.begin() + 1, local.radii.end(), cleaning.smooth_radius);
  if (!cloud.partition.layers.is_thick() || whole == local.radii.end()) return 0;
  return static_cast<std::uint8_t>(whole - local.radii.begin());
}

NormalFacts estimate(StageRunner& runner, const CleaningOptions& cleaning,
                     const LocalCleaning& local, RawCloud& cloud) {
  if (runner.job.normals.source == NormalSource::kPoles) return take_poles(runner, cloud);
  const SideRule rule = side_rule(runner, cloud);
  std::vector<NormalEstimateOptions> options;
  for (const double radius : local.radii) {
    CleaningOptions of_level = cleaning;
    of_level.smooth_radius = radius;
    options.push_back(estimate_options(runner.job, cloud.partition, of_level));
    options.back().stop = &runner.stop;
  }
  run_pass(runner, normal_pass(local, options, level_of_untouched(cleaning, local, cloud), rule),
           cloud);
  NormalFacts normals;
  normals.source = NormalSource::kEstimate;
  normals.orientation = rule.by;
  normals.neighbors = options.back().neighbors;
  normals.max_radius = options.back().max_radius;
  return normals;
}

/// Whether normals point to the right side before patches are oriented.
bool are_oriented(const NormalFacts& normals) {
  return !is_propagated(normals.orientation) && normals.orientation != Orientation::kNone;
}

void smooth(StageRunner& runner, const LocalCleaning& local, bool oriented, RawCloud& cloud,
            CleaningFacts& facts) {
  const std::string before = cloud.stage;
  const bool thins = local.spacings.back() > 0.0;
  cloud.kept_stage = before;
  std::vector<RawPass> passes;
  for (int pass = 0; pass + (thins ? 1 : 0) < facts.options.smooth_passes; ++pass)
    passes.push_back(smooth_pass(runner, local, oriented, pass));
  if (thins) passes.push_back(thin_and_smooth_pass(runner, local, oriented));
  // Its points may be there as those of a pass before the last one, which measures no moves.
  passes.back().options += key_line("moves are measured", "yes");
  passes.back().look = [&runner, before, schema = cloud.schema, stage = passes.back().stage](
                           ChunkId chunk, const PassResult& after) {
    measure_moves(runner, before, schema, stage, chunk, after);
  };
  for (const RawPass& pass : passes) run_pass(runner, pass, cloud);
  cloud.kept_stage.clear();
  if (!runner.communicator.is_root()) return;
  take_moves(runner, cloud, facts);
  runner.store.discard_results(before);
}

std::optional<PatchOrientation> propagate(StageRunner& runner, const RawCloud& cloud,
                                          const CleaningFacts& facts, NormalFacts& normals) {
  if (!is_propagated(normals.orientation)) return std::nullopt;
  const double thinned = facts.options.thin_to_spacing;
  const double farthest =
      facts.is_local ? std::max(thinned, kThinningPerRadius * facts.most_radius) : thinned;
  constexpr double kReach = 3.0;
  PatchOrientation orientation = orient_cloud(
      runner, cloud, normals.orientation,
      std::max({cloud.partition.spacing, thinned, merged_spacing(facts.options)}),
      std::max(reach_of_normals(runner.job, cloud.partition, facts.options), kReach * farthest));
  take_facts(orientation, normals);
  return orientation;
}

/// The raw points' numbers that the final partition is to report.
void take_over(const RawCloud& cloud, Partition& partition) {
  partition.points_read = cloud.partition.points_read;
  for (const auto& [reason, count] : cloud.partition.dropped) partition.dropped[reason] += count;
  for (const auto& [reason, count] : cloud.dropped) partition.dropped[reason] += count;
  partition.layers = cloud.partition.layers;
  partition.coordinate_system = cloud.partition.coordinate_system;
  partition.meters_per_unit = cloud.partition.meters_per_unit;
  partition.has_wide_colors = cloud.partition.has_wide_colors;
}

/// The raw points, and what the passes start from.
RawCloud raw_cloud(StageRunner& runner, Partition partition) {
  RawCloud cloud;
  cloud.partition = std::move(partition);
  cloud.stage = kRawCut.points();
  cloud.key = stored_key(runner.store, cloud.stage) + chunks_line(cloud.partition);
  cloud.points = cloud.partition.points();
  cloud.schema = cloud.partition.schema;
  return cloud;
}

std::vector<double> radii_in_spacings(const Partition& measured) {
  std::vector<double> radii = measured.automatic_radii;
  for (double& radius : radii) radius /= measured.spacing;
  return radii;
}

CutPoints partition_cleaned(StageRunner& runner) {
  runner.of_points.clear();
  CutPoints raw = raw_points(runner);
  RawCloud cloud = raw_cloud(runner, std::move(raw.partition));
  warn_of_steps(runner, cloud.partition, cleaning_for(runner.job.cleaning, cloud.partition));
  CleaningFacts facts = describe_layers(runner, cloud.partition);
  warn_of_twins(runner, cloud.partition, facts);
  check_smoothing(runner.job, facts);
  check_side(runner.job, cloud.partition.points_without_view);
  NormalFacts normals;
  normals.source = NormalSource::kFile;
  const LocalCleaning local = local_cleaning(runner, cloud, facts);
  // Place by place, layers may turn out to be thin: nothing is smoothed then.
  warn_of_double_layers(runner, cloud.partition, facts);
  if (runner.job.output.vertex_quality)
    run_pass(runner, quality_pass(cloud, local, normal_origin(runner, cloud), runner.stop), cloud);
  drop_and_merge(runner, facts.options, local, cloud);
  if (runner.job.estimates_normals) normals = estimate(runner, facts.options, local, cloud);
  const bool oriented = are_oriented(normals);
  if (facts.options.smooth_radius > 0.0)
    smooth(runner, local, oriented, cloud, facts);
  else if (facts.options.thin_to_spacing > 0.0)
    run_pass(runner, thin_pass(runner, local, oriented), cloud);
  const auto orientation = propagate(runner, cloud, facts, normals);
  const PatchOrientation* turns = orientation ? &*orientation : nullptr;
  require_points(runner, cloud);
  CutPoints points = partition_by_team(runner, kFinalCut, [&] {
    CutPoints cut =
        cut_and_sort({.open = [&](auto*) { return open_cleaned(runner.store, cloud, turns); },
                      .stages = kFinalCut,
                      .are_scans = false,
                      .order = chunks_line(cloud.partition),
                      .likely_radii = radii_in_spacings(cloud.partition)},
                     runner);
    take_over(cloud, cut.partition);
    cut.partition.cleaning = facts;
    cut.partition.normals = normals;
    if (runner.job.estimates_normals) {
      const bool are_poles = normals.source == NormalSource::kPoles;
      runner.say_of_points({(are_poles ? "normals: poles, " : "normals: estimated, ") +
                                describe_orientation(normals),
                            describe_normals(normals)});
      warn_of_orientation(runner, normals);
    }
    return cut;
  });
  // The first prediction counts.
  if (raw.predicted_disk_bytes != 0) points.predicted_disk_bytes = raw.predicted_disk_bytes;
  return points;
}

/// The scans' own points, cut and sorted.
CutPoints partition_scans(StageRunner& runner) {
  return partition_by_team(runner, kFinalCut, [&] {
    CutPoints cut = cut_and_sort(scans_as_input(runner, kFinalCut), runner);
    warn_of_steps(runner, cut.partition, cleaning_for(runner.job.cleaning, cut.partition));
    cut.partition.cleaning = describe_layers(runner, cut.partition);
    warn_of_double_layers(runner, cut.partition, cut.partition.cleaning);
    warn_of_twins(runner, cut.partition, cut.partition.cleaning);
    cut.partition.normals.source = NormalSource::kFile;
    return cut;
  });
}

CutPoints make_points(StageRunner& runner) {
  if (!runner.job.needs_cleaning_or_normals()) return partition_scans(runner);
  try {
    return partition_cleaned(runner);
  } catch (const RawPointsGone&) {
    runner.note("the raw points are read again for that");
    by_root(runner, [&] { discard_raw_stages(runner.store); });
    return partition_cleaned(runner);
  }
}

}  // namespace

void check_viewpoint(const ResolvedJob& job) {
  const NormalOptions& normals = job.normals;
  if (!job.estimates_normals || normals.orientation != Orientation::kViewpoint || normals.viewpoint)
    return;
  throw_usage(setting(job, "normals.orientation", "viewpoint") + " needs " +
                  setting_name(job, "normals.viewpoint"),
              {});
}

void check_side(const ResolvedJob& job, std::uint64_t points_without_view) {
  check_viewpoint(job);
  const bool needs_views =
      job.estimates_normals && job.orientation_rule(points_without_view) == Orientation::kScanner;
  if (!needs_views || points_without_view == 0) return;
  throw_bad_input("it is not known where some points were scanned from",
                  {.file = job.files.front(),
                   .found = std::to_string(points_without_view) + " points without a scanner",
                   .expected = "poses, " + setting_name(job, "input.scanner") + ", " +
                               setting_name(job, "input.trajectory") +
                               ", or files that say where the scanner was",
                   .advice = "Or " + setting(job, "normals.orientation", "propagate")});
}

void check_smoothing(const Job& job, const CleaningFacts& facts) {
  constexpr double kMostSpacings = 64.0;
  if (!(facts.spacing > 0.0) || facts.options.smooth_radius <= kMostSpacings * facts.spacing)
    return;
  throw_usage(setting_name(job, "cleaning.smooth_radius") + " is far too large for these points",
              {.found = format_number(facts.options.smooth_radius) + ", " +
                        format_number(facts.options.smooth_radius / facts.spacing) +
                        " times their spacing " + format_number(facts.spacing),
               .expected = "at most " + format_number(kMostSpacings) + " spacings, usually 4",
               .advice = setting(job, "cleaning.auto", "true") + " chooses it."});
}

CutPoints partition_points(const ResolvedJob& job, StageRunner& runner) {
  std::optional<Partition> stored = begin_partition(runner, kFinalCut, points_key(job));
  runner.of_points.clear();
  if (stored) {
    runner.note("resuming: the points are partitioned already");
    for (const SaidLine& line : stored->said) runner.say_of_points(line);
  }
  CutPoints points = stored ? CutPoints{std::move(*stored), 0} : make_points(runner);
  if (runner.communicator.is_root()) discard_raw_stages(runner.store);
  return points;
}

}  // namespace orbweave
