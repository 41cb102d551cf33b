#include "engine/pipeline/prepare_stage.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "engine/cleaning/outliers.h"
#include "engine/cleaning/projection.h"
#include "engine/cleaning/thinning.h"
#include "engine/normals/estimate_normals.h"
#include "engine/pipeline/cut_exchange.h"
#include "engine/pipeline/orientation_stage.h"
#include "engine/pipeline/prepared_source.h"
#include "engine/pipeline/raw_passes.h"
#include "engine/pipeline/scan_input.h"
#include "engine/pipeline/stage_keys.h"
#include "io/chunk_points.h"
#include "io/error.h"
#include "io/quantity.h"
#include "io/scan_source.h"

namespace orbweave {
namespace {

constexpr const char* kRawStage = "raw";
/// Smoothed layers are wider than spacings: the plane of a normal has to span them.
constexpr std::size_t kNeighborsAcrossLayers = 48;
constexpr int kMostSmoothPasses = 8;
/// Points on different sheets do not replace one another: normals less than 60 degrees apart do.
constexpr double kSameSheetCosine = 0.5;

/// What the job asks for; an automatic choice gives way to the numbers that the job has.
PrepareOptions resolve(const PrepareOptions& wanted, const PrepareOptions& chosen) {
  if (!wanted.automatic) return wanted;
  PrepareOptions options = chosen;
  options.automatic = true;
  if (wanted.outlier_sigma > 0.0) options.outlier_sigma = wanted.outlier_sigma;
  if (wanted.merge_tolerance > 0.0) options.merge_tolerance = wanted.merge_tolerance;
  if (wanted.smooth_radius > 0.0) options.smooth_radius = wanted.smooth_radius;
  if (wanted.smooth_passes != PrepareOptions{}.smooth_passes)
    options.smooth_passes = wanted.smooth_passes;
  if (wanted.thin_to_spacing > 0.0) options.thin_to_spacing = wanted.thin_to_spacing;
  return options;
}

/// Says what was measured, and what follows from it or would have followed.
PrepareFacts describe_layers(JobContext& context, const Partition& scans) {
  PrepareFacts facts = clean_up_for(context.job.prepare, scans);
  if (context.job.prepare.automatic) {
    context.note("clean-up: " + facts.reason);
  } else if (!cleans(context.job.prepare) && scans.layers.is_thick()) {
    context.warn(
        "the scanned layers are thick and are taken as they are; prepare.auto = true would clean "
        "them up: " +
        facts.reason);
  }
  return facts;
}

PointCloud kept_points(const PointCloud& points, const std::vector<std::uint8_t>& kept) {
  PointCloud result;
  result.schema = points.schema;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (kept[i] != 0) result.append(points, i);
  return result;
}

RawPass outlier_pass(const PrepareOptions& options, const RawCloud& cloud) {
  const OutlierOptions outliers{.sigma = options.outlier_sigma,
                                .max_radius = cloud.partition.normal_radius};
  return {.stage = "raw_outliers",
          .options = key_line("prepare.outlier_sigma", format_exact(outliers.sigma)) +
                     key_line("reach of outliers", format_exact(outliers.max_radius)),
          .halo = outlier_halo(outliers),
          .dropped_reason = "outlier",
          .work = [outliers](PassPoints&& points) {
            auto kept = find_outliers(points.positions, points.begin, points.end, outliers);
            for (std::uint8_t& flag : kept) flag ^= 1;
            return kept_points(points.own, kept);
          }};
}

RawPass merge_pass(const PrepareOptions& options) {
  const ThinningOptions merging{options.merge_tolerance, kSameSheetCosine};
  return {.stage = "raw_merged",
          .options = key_line("prepare.merge_tolerance", format_exact(merging.spacing)),
          .halo = merging_halo(merging),
          .drift = merging.spacing,
          .dropped_reason = "merged with another point",
          .work = [merging](PassPoints&& points) {
            MergedPoints merged =
                merge_points(points.positions, points.normals, points.begin, points.end, merging);
            points.own.positions = std::move(merged.positions);
            if (!merged.normals.empty()) points.own.normals = std::move(merged.normals);
            return kept_points(points.own, merged.kept);
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
    ViewCode code;
    std::memcpy(&code, points.attribute_row(i).data() + *view, sizeof code);
    return code.known() ? decode_view(code) : Vec3{};
  }
};

std::string text_of(const SideRule& rule) {
  return std::string(name_of(rule.by)) + " " + format_exact(rule.vector.x) + " " +
         format_exact(rule.vector.y) + " " + format_exact(rule.vector.z);
}

/// The first that applies: scanner, viewpoint, up, propagation.
SideRule side_rule(const JobContext& context, const RawCloud& cloud) {
  const NormalOptions& options = context.job.normals;
  const bool views = cloud.partition.points_without_view == 0;
  SideRule rule{side_of_normals(options, cloud.partition.points_without_view), {}};
  if (rule.by == Orientation::kScanner && !views)
    throw_bad_input(
        "it is not known where some points were scanned from",
        {.file = context.files.front(),
         .found = std::to_string(cloud.partition.points_without_view) + " points without a scanner",
         .expected = "poses, input.scanner, or files that say where the scanner was",
         .advice = "Or choose another normals.orientation, such as \"propagate\"."});
  if (rule.by == Orientation::kViewpoint) {
    if (!options.viewpoint)
      throw_usage("normals.orientation = \"viewpoint\" needs normals.viewpoint", {});
    rule.vector = *options.viewpoint;
  }
  if (rule.by == Orientation::kUp) rule.vector = options.up.value_or(Vec3{0.0, 0.0, 1.0});
  return rule;
}

PointCloud with_normals(PassPoints&& points, const NormalEstimateOptions& options,
                        const SideRule& rule) {
  EstimatedNormals estimated =
      estimate_normals(points.positions, points.begin, points.end, options);
  const std::optional<std::size_t> view = view_offset(points.own.schema);
  std::vector<std::uint8_t> kept(points.own.size());
  for (std::size_t i = 0; i < points.own.size(); ++i) {
    Vec3& normal = estimated.normals[i];
    kept[i] = normal == Vec3{} ? 0 : 1;
    if (dot(normal, rule.wanted(points.own, i, view)) < 0.0) normal = -normal;
  }
  points.own.normals = std::move(estimated.normals);
  return kept_points(points.own, kept);
}

RawPass normal_pass(const NormalEstimateOptions& options, const SideRule& rule) {
  return {.stage = "raw_normals",
          .options = key_line("normals.neighbors", std::to_string(options.neighbors)) +
                     key_line("reach of normals", format_exact(options.max_radius)) +
                     key_line("normals.orientation", text_of(rule)),
          .halo = options.max_radius,
          .adds_normals = true,
          .dropped_reason = "too few neighbours for a normal",
          .work = [options, rule](PassPoints&& points) {
            return with_normals(std::move(points), options, rule);
          }};
}

void normalize_all(std::vector<Vec3>& normals) {
  for (Vec3& normal : normals) normal = normalized(normal);
}

RawPass smooth_pass(const PrepareOptions& options, bool oriented, int pass) {
  const ProjectionOptions projection{options.smooth_radius, oriented};
  return {.stage = "raw_smooth_" + std::to_string(pass + 1),
          .options = key_line("prepare.smooth_radius", format_exact(projection.radius)) +
                     key_line("oriented", oriented ? "yes" : "no"),
          .halo = projection.radius,
          .drift = projection.radius,
          .dropped_reason = "",
          .work = [projection](PassPoints&& points) {
            normalize_all(points.normals);
            ProjectedPoints projected = project_points(points.positions, points.normals,
                                                       points.begin, points.end, projection);
            points.own.positions = std::move(projected.positions);
            points.own.normals = std::move(projected.normals);
            return std::move(points.own);
          }};
}

RawPass thin_pass(const PrepareOptions& options, bool oriented) {
  const ThinningOptions thinning{options.thin_to_spacing, kSameSheetCosine};
  return {.stage = "raw_thinned",
          .options = key_line("prepare.thin_to_spacing", format_exact(thinning.spacing)) +
                     key_line("oriented", oriented ? "yes" : "no"),
          .halo = thinning_halo(thinning),
          .dropped_reason = "thinned",
          .work = [thinning, oriented](PassPoints&& points) {
            if (!oriented) points.normals.clear();
            normalize_all(points.normals);
            return kept_points(points.own, thin_points(points.positions, points.normals,
                                                       points.begin, points.end, thinning));
          }};
}

/// The raw points in chunks; resumes from the store where it holds them whole.
Partition raw_partition(JobContext& context) {
  if (std::optional<Partition> stored =
          begin_partition(context, kRawStage, raw_points_key(context)))
    return std::move(*stored);
  return partition_by_team(context, kRawStage, [&] {
    return cut_and_sort(context, scans_as_input(context, kRawStage, "raw "));
  });
}

/// Mean distance between the points of two stages that hold the same points.
void measure_moves(JobContext& context, const RawCloud& cloud, const std::string& before,
                   PrepareFacts& facts) {
  double sum = 0.0;
  std::uint64_t moved = 0;
  for (ChunkId chunk = 0; chunk < cloud.partition.octree.chunks().size(); ++chunk) {
    const PointCloud from = load_points(context.store, chunk, cloud.schema, before);
    const PointCloud to = load_points(context.store, chunk, cloud.schema, cloud.stage);
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (from.positions[i] == to.positions[i]) continue;
      sum += norm(to.positions[i] - from.positions[i]);
      ++moved;
    }
  }
  facts.points_moved = moved;
  facts.mean_move = moved == 0 ? 0.0 : sum / static_cast<double>(moved);
}

/// The same, from what an earlier run left of it where it did.
void take_moves(JobContext& context, const RawCloud& cloud, const std::string& before,
                PrepareFacts& facts) {
  constexpr const char* kMoves = "moves";
  if (const auto stored = context.store.document(cloud.stage, kMoves)) {
    const nlohmann::json moves = nlohmann::json::parse(*stored);
    facts.points_moved = moves.at(0);
    facts.mean_move = moves.at(1);
    return;
  }
  measure_moves(context, cloud, before, facts);
  context.store.commit_document(
      cloud.stage, kMoves, nlohmann::json::array({facts.points_moved, facts.mean_move}).dump());
}

/// A radius beyond that flattens everything, and its halo holds it all; somebody mistook the unit.
void check_radius(const PrepareFacts& facts) {
  constexpr double kMostSpacings = 64.0;
  if (!(facts.spacing > 0.0) || facts.options.smooth_radius <= kMostSpacings * facts.spacing)
    return;
  throw_usage("prepare.smooth_radius is far too large for these points",
              {.found = format_number(facts.options.smooth_radius) + ", " +
                        format_number(facts.options.smooth_radius / facts.spacing) +
                        " times their spacing " + format_number(facts.spacing),
               .expected = "at most " + format_number(kMostSpacings) + " spacings, usually 4",
               .advice = "prepare.auto = true chooses it."});
}

NormalEstimateOptions estimate_options(const JobContext& context, const RawCloud& cloud,
                                       const PrepareOptions& clean_up) {
  NormalEstimateOptions options;
  options.neighbors = static_cast<std::size_t>(context.job.normals.neighbors);
  options.max_radius = cloud.partition.normal_radius;
  if (clean_up.smooth_radius > 0.0) {
    options.neighbors = std::max(options.neighbors, kNeighborsAcrossLayers);
    options.max_radius = std::max(options.max_radius, clean_up.smooth_radius);
  }
  return options;
}

/// The passes in their order.
class Preparation {
 public:
  Preparation(JobContext& context, RawCloud& cloud, PrepareFacts& facts)
      : context_(context), cloud_(cloud), facts_(facts) {}

  void drop_and_merge() {
    if (facts_.options.outlier_sigma > 0.0)
      run_pass(context_, outlier_pass(facts_.options, cloud_), cloud_);
    if (facts_.options.merge_tolerance > 0.0)
      run_pass(context_, merge_pass(facts_.options), cloud_);
  }
  void estimate(NormalFacts& normals) {
    const SideRule rule = side_rule(context_, cloud_);
    const NormalEstimateOptions options = estimate_options(context_, cloud_, facts_.options);
    run_pass(context_, normal_pass(options, rule), cloud_);
    oriented_ = rule.by != Orientation::kPropagate && rule.by != Orientation::kNone;
    normals.source = "estimated";
    normals.orientation = name_of(rule.by);
    normals.neighbors = options.neighbors;
    normals.max_radius = options.max_radius;
  }
  void smooth_and_thin() {
    if (facts_.options.smooth_radius > 0.0) {
      const std::string before = cloud_.stage;
      cloud_.kept_stage = before;
      for (int pass = 0; pass < facts_.options.smooth_passes; ++pass)
        run_pass(context_, smooth_pass(facts_.options, oriented_, pass), cloud_);
      cloud_.kept_stage.clear();
      if (context_.team.leads()) {
        take_moves(context_, cloud_, before, facts_);
        context_.store.discard_results(before);
      }
    }
    if (facts_.options.thin_to_spacing > 0.0)
      run_pass(context_, thin_pass(facts_.options, oriented_), cloud_);
  }

 private:
  JobContext& context_;
  RawCloud& cloud_;
  PrepareFacts& facts_;
  bool oriented_ = true;
};

std::optional<PatchOrientation> propagate(JobContext& context, const RawCloud& cloud,
                                          const PrepareFacts& facts, NormalFacts& normals) {
  if (normals.orientation != name_of(Orientation::kPropagate)) return std::nullopt;
  const double thinned = facts.options.thin_to_spacing;
  constexpr double kReach = 3.0;
  PatchOrientation orientation =
      orient_cloud(context, cloud, std::max(cloud.partition.spacing, thinned),
                   std::max(cloud.partition.normal_radius, kReach * thinned));
  normals.patches = orientation.patches.size();
  normals.components = orientation.components;
  normals.contested = orientation.contested;
  normals.satisfied = orientation.satisfied;
  return orientation;
}

/// The raw points' numbers that the final partition is to report.
void take_over(const RawCloud& cloud, Partition& partition) {
  partition.points_read = cloud.partition.points_read;
  for (const auto& [reason, count] : cloud.partition.dropped) partition.dropped[reason] += count;
  for (const auto& [reason, count] : cloud.dropped) partition.dropped[reason] += count;
  partition.layers = cloud.partition.layers;
  partition.coordinate_system = cloud.partition.coordinate_system;
}

std::string describe(const NormalFacts& normals) {
  std::string line = "normals: estimated from up to " + std::to_string(normals.neighbors) +
                     " neighbours within " + format_number(normals.max_radius) + ", side by " +
                     normals.orientation;
  if (normals.patches > 0)
    line += "; " + format_count(normals.patches) + " patches, " + format_count(normals.contested) +
            " of them contested";
  return line;
}

Partition partition_prepared(JobContext& context, bool estimates) {
  RawCloud cloud;
  cloud.partition = raw_partition(context);
  cloud.stage = kRawStage;
  cloud.key = raw_points_key(context) + chunks_line(cloud.partition);
  cloud.points = cloud.partition.points();
  cloud.schema = cloud.partition.schema;
  PrepareFacts facts = describe_layers(context, cloud.partition);
  check_radius(facts);
  NormalFacts normals;
  normals.source = "file";
  Preparation preparation(context, cloud, facts);
  preparation.drop_and_merge();
  if (estimates) preparation.estimate(normals);
  preparation.smooth_and_thin();
  const auto orientation = propagate(context, cloud, facts, normals);
  const PatchOrientation* turns = orientation ? &*orientation : nullptr;
  return partition_by_team(context, kPointsStage, [&] {
    Partition partition = cut_and_sort(
        context, {.open = [&](auto*) { return open_prepared(context.store, cloud, turns); },
                  .stage = kPointsStage,
                  .prefix = "",
                  .are_scans = false,
                  .order = chunks_line(cloud.partition)});
    take_over(cloud, partition);
    partition.prepare = facts;
    partition.normals = normals;
    if (estimates) context.note(describe(normals));
    return partition;
  });
}

}  // namespace

bool cleans(const PrepareOptions& options) {
  return options.outlier_sigma > 0.0 || options.merge_tolerance > 0.0 ||
         options.smooth_radius > 0.0 || options.thin_to_spacing > 0.0;
}

bool needs_preparation(const InputContext& context) {
  const PrepareOptions& wanted = context.job.prepare;
  return wanted.automatic || cleans(wanted) || estimates_normals(context);
}

PrepareFacts clean_up_for(const PrepareOptions& wanted, const Partition& scans) {
  PrepareFacts facts;
  facts.thickness = scans.layers.thickness;
  facts.spacing = scans.spacing;
  const PrepareChoice choice = choose_preparation(scans.layers);
  facts.options = resolve(wanted, choice.options);
  facts.reason = choice.reason;
  return facts;
}

Orientation side_of_normals(const NormalOptions& options, std::uint64_t points_without_view) {
  if (options.orientation != Orientation::kAuto) return options.orientation;
  if (points_without_view == 0) return Orientation::kScanner;
  if (options.viewpoint) return Orientation::kViewpoint;
  return options.up ? Orientation::kUp : Orientation::kPropagate;
}

const char* name_of(Orientation orientation) {
  constexpr std::array<const char*, 6> kNames = {"auto", "scanner",   "viewpoint",
                                                 "up",   "propagate", "none"};
  return kNames[static_cast<std::size_t>(orientation)];
}

CloudInput scans_as_input(const InputContext& context, const std::string& stage,
                          const std::string& prefix) {
  return {.open = [&context](auto* notes) { return open_scans(context, notes); },
          .stage = stage,
          .prefix = prefix,
          .are_scans = true,
          .order = {}};
}

Partition prepared_partition(JobContext& context) {
  if (needs_preparation(context)) {
    const bool estimates = estimates_normals(context);
    try {
      return partition_prepared(context, estimates);
    } catch (const RawPointsGone&) {
      context.note("the raw points are read again for that");
      by_leader(context, [&] { discard_raw_stages(context.store); });
      return partition_prepared(context, estimates);
    }
  }
  return partition_by_team(context, kPointsStage, [&] {
    Partition partition = cut_and_sort(context, scans_as_input(context, kPointsStage, ""));
    partition.prepare = describe_layers(context, partition);
    partition.normals.source = "file";
    return partition;
  });
}

const std::vector<std::string>& raw_stages() {
  static const std::vector<std::string> stages = [] {
    std::vector<std::string> names = {kRawStage, "raw_outliers", "raw_merged", "raw_normals"};
    for (int pass = 1; pass <= kMostSmoothPasses; ++pass)
      names.push_back("raw_smooth_" + std::to_string(pass));
    names.insert(names.end(), {"raw_thinned", kPatchStage, kTurnStage});
    return names;
  }();
  return stages;
}

void discard_raw_stages(ChunkStore& store) {
  for (const std::string& stage : raw_stages()) store.discard_stage(stage);
  store.discard_stage(cut_stage_of(kRawStage));
}

}  // namespace orbweave
