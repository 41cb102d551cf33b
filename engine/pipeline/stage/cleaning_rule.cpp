#include "engine/pipeline/stage/cleaning_rule.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/cleaning/clusters.h"
#include "engine/cleaning/projection.h"
#include "engine/spacing/layer_thickness.h"
#include "engine/spacing/site_points.h"

namespace orbweave {
namespace {

CleaningOptions cleaning_options(const CleaningChoice& choice) {
  CleaningOptions options;
  options.outlier_sigma = choice.outlier_sigma;
  options.smooth_radius = choice.smooth_radius;
  options.smooth_passes = choice.smooth_passes;
  options.thin_to_spacing = choice.thin_to_spacing;
  options.cluster_points = choice.cluster_points;
  return options;
}

/// What the job asks for; an automatic choice gives way to the numbers that the job has.
CleaningOptions applied_options(const CleaningOptions& wanted, const CleaningOptions& chosen) {
  if (!wanted.automatic) return wanted;
  CleaningOptions options = chosen;
  options.automatic = true;
  if (wanted.outlier_sigma > 0.0) options.outlier_sigma = wanted.outlier_sigma;
  if (wanted.merge_tolerance > 0.0) options.merge_tolerance = wanted.merge_tolerance;
  if (wanted.smooth_radius > 0.0) options.smooth_radius = wanted.smooth_radius;
  if (wanted.smooth_passes != CleaningOptions{}.smooth_passes)
    options.smooth_passes = wanted.smooth_passes;
  if (wanted.thin_to_spacing > 0.0) options.thin_to_spacing = wanted.thin_to_spacing;
  if (wanted.cluster_points) options.cluster_points = wanted.cluster_points;
  options.min_surfaceness = wanted.min_surfaceness;
  return options;
}

/// A step of the cleaning as a verb and what it is applied to.
struct Step {
  const char* would;
  const char* did;
  std::string what;
};

/// In the order of the passes.
std::vector<Step> steps_of(const CleaningOptions& options, double spacing) {
  std::vector<Step> steps;
  const auto drop = [&](std::string what) {
    steps.push_back({"drop", "dropped", std::move(what)});
  };
  if (options.outlier_sigma > 0.0)
    drop("outliers beyond " + short_text(options.outlier_sigma) + " standard deviations");
  if (options.cluster_points.value_or(0) > 0)
    drop("clusters of fewer than " + std::to_string(*options.cluster_points) + " points");
  if (options.merge_tolerance > 0.0)
    steps.push_back({"merge", "merged", "points within " + short_text(options.merge_tolerance)});
  if (options.min_surfaceness > 0.0)
    drop("points of a surfaceness below " + short_text(options.min_surfaceness));
  if (options.smooth_radius > 0.0) {
    std::string what = "in " + std::to_string(options.smooth_passes) +
                       (options.smooth_passes == 1 ? " pass" : " passes") + " of radius " +
                       short_text(options.smooth_radius);
    if (spacing > 0.0) what += " (" + short_text(options.smooth_radius / spacing) + " spacings)";
    steps.push_back({"smooth", "smoothed", std::move(what)});
  }
  if (options.thin_to_spacing > 0.0)
    steps.push_back({"thin", "thinned", "to a spacing of " + short_text(options.thin_to_spacing)});
  return steps;
}

std::string text_of(const std::vector<Step>& steps, const char* Step::*verb) {
  std::string text;
  for (const Step& step : steps)
    text += (text.empty() ? "" : ", ") + std::string(step.*verb) + " " + step.what;
  return text;
}

/// What was measured, and what is done about it; else what automatic cleaning would do.
std::string reason_of(const CleaningChoice& choice, const CleaningOptions& applied,
                      const LayerThickness& layers) {
  const std::vector<Step> steps = steps_of(applied, layers.spacing);
  if (!steps.empty()) return choice.noise + ": " + text_of(steps, &Step::did);
  if (layers.measured == 0) return choice.noise + ": no cleaning";
  const std::vector<Step> wanted = steps_of(cleaning_options(choice), layers.spacing);
  if (wanted.empty()) return choice.noise + ": no cleaning needed";
  return choice.noise + ": not cleaned; cleaning.auto would " + text_of(wanted, &Step::would);
}

}  // namespace

CleaningFacts cleaning_for(const CleaningOptions& wanted, const Partition& scans) {
  CleaningFacts facts;
  facts.thickness = scans.layers.thickness;
  facts.spacing = scans.spacing;
  const CleaningChoice choice = choose_cleaning(scans.layers);
  facts.options = applied_options(wanted, cleaning_options(choice));
  facts.reason = reason_of(choice, facts.options, scans.layers);
  // Numbers that the job has hold everywhere.
  facts.is_local = wanted.automatic && choice.smooth_radius > 0.0 && wanted.smooth_radius == 0.0 &&
                   wanted.thin_to_spacing == 0.0;
  facts.least_radius = facts.options.smooth_radius;
  facts.most_radius = facts.options.smooth_radius;
  if (facts.is_local) facts.most_radius = std::max(facts.most_radius, scans.layers.largest_radius);
  return facts;
}

NoisePlaceOptions noise_options(const Partition& scans) {
  // Layers are told from leaves of trees by neighbourhoods five times as wide as they are thick:
  // 384 points of a surface are 22 spacings across, four times as many twice as much.
  constexpr double kThinPerSpacing = 0.5, kReachPerCell = 0.5;
  constexpr std::size_t kPoints = 384;
  const LayerThickness& layers = scans.layers;
  const int wider = layers.thickness > kThinPerSpacing * layers.spacing ? 2 : 1;
  const double cell = noise_cell(layers);
  return {.cell = cell,
          .reach = std::max(wider * kReachPerCell * cell, scans.normal_radius),
          .most_points = kPoints * static_cast<std::size_t>(wider * wider)};
}

double merged_spacing(const CleaningOptions& cleaning) { return 1.2 * cleaning.merge_tolerance; }

double reach_of_normals(const ResolvedJob& job, const Partition& scans,
                        const CleaningOptions& cleaning) {
  constexpr double kMargin = 1.5;
  const double farthest = std::sqrt(static_cast<double>(job.normals.neighbors) / std::numbers::pi);
  return std::max(scans.normal_radius, kMargin * farthest * merged_spacing(cleaning));
}

NormalEstimateOptions estimate_options(const ResolvedJob& job, const Partition& scans,
                                       const CleaningOptions& cleaning) {
  // Smoothed layers are wider than spacings: the plane of a normal has to span them.
  constexpr std::size_t kNeighborsAcrossLayers = 48;
  NormalEstimateOptions options;
  options.neighbors = static_cast<std::size_t>(job.normals.neighbors);
  options.max_radius = reach_of_normals(job, scans, cleaning);
  if (cleaning.smooth_radius > 0.0) {
    options.neighbors = std::max(options.neighbors, kNeighborsAcrossLayers);
    options.max_radius = std::max(options.max_radius, cleaning.smooth_radius);
    // Smoothing is to project these points onto one surface anyway.
    options.shared_side = shared_side(ProjectionOptions{.radius = cleaning.smooth_radius});
  }
  return options;
}

double reach_of_cleaning(const ResolvedJob& job, const Partition& scans) {
  if (!job.needs_cleaning_or_normals() || !(scans.normal_radius > 0.0)) return 0.0;
  const CleaningFacts facts = cleaning_for(job.cleaning, scans);
  CleaningOptions options = facts.options;
  options.smooth_radius = facts.most_radius;
  double reach = scans.normal_radius;
  if (facts.is_local || job.output.vertex_quality)
    reach = std::max(reach, noise_halo(noise_options(scans)));
  if (options.cluster_points.value_or(0) > 0)
    reach = std::max(reach, cluster_halo({.gap = scans.normal_radius}));
  if (options.smooth_radius > 0.0)
    reach = std::max(reach, projection_halo(ProjectionOptions{.radius = options.smooth_radius}));
  if (!job.estimates_normals) return reach;
  return std::max(reach, normal_halo(estimate_options(job, scans, options)));
}

}  // namespace orbweave
