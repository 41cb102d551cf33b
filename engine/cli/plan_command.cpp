// orbweave plan: what a run would do.
#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>

#include "engine/cli/commands.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/pipeline/job_paths.h"
#include "engine/planning/plan_job.h"
#include "io/job/setting.h"
#include "io/report/hole_summary.h"
#include "io/report/output_names.h"
#include "io/report/reasons.h"
#include "io/system/glob.h"
#include "io/text/quantity.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

struct PlanOptions {
  JobArguments job;
  bool json = false;
};

/// What stays open by the options; which loops there are is known after the reconstruction.
std::vector<std::string> left_open(const FillOptions& fill) {
  std::vector<std::string> kinds;
  if (fill.keep_outer_border) kinds.emplace_back("outer borders of open sheets");
  if (fill.max_edges > 0)
    kinds.push_back("holes of more than " + counted(fill.max_edges, "edge", "edges"));
  if (!fill.max_diameter && fill.keep_outer_border) kinds.emplace_back("wide gaps of open scenes");
  if (fill.max_diameter && std::isfinite(*fill.max_diameter))
    kinds.push_back("holes wider than " + format_number(*fill.max_diameter));
  if (std::isfinite(fill.max_perimeter))
    kinds.push_back("holes with a rim longer than " + format_number(fill.max_perimeter));
  return kinds;
}

Facts fill_plan(const Job& job) {
  const FillOptions& fill = job.fill;
  if (!fill.enabled)
    return {{"holes", "all stay open (" + setting(job, "fill.enabled", "false") + ")"}};
  const char* kernel = fill.kernel == FillKernel::kBiharmonic ? "biharmonic" : "triharmonic";
  const std::vector<std::string> kinds = left_open(fill);
  Facts facts = {{"holes", std::string("filled (") + kernel + ", neighborhood " +
                               format_number(fill.neighborhood) + " times the radius)"},
                 {"left open", kinds.empty() ? "nothing" : joined(kinds)}};
  if (fill.min_triangles > 0)
    facts.emplace_back("removed", "separate pieces of fewer than " +
                                      counted(*fill.min_triangles, "triangle", "triangles"));
  return facts;
}

/// Where normals come from, and the cleaning before.
Facts cleaning_plan(const JobPlan& plan) {
  Facts facts;
  facts.emplace_back("normals", plan.normals.orientation == Orientation::kAuto
                                    ? "those of the file"
                                    : std::string(plan.normals.source == NormalSource::kPoles
                                                      ? "poles, side by "
                                                      : "estimated, side by ") +
                                          text_of(plan.normals.orientation));
  const CleaningOptions& options = plan.cleaning.options;
  std::vector<std::string> stages;
  if (options.outlier_sigma > 0.0)
    stages.push_back("outliers beyond " + format_number(options.outlier_sigma) + " deviations go");
  if (options.merge_tolerance > 0.0)
    stages.push_back("points within " + format_number(options.merge_tolerance) + " become one");
  if (options.smooth_radius > 0.0)
    stages.push_back("smoothed within " + format_number(options.smooth_radius) + " (" +
                     counted(static_cast<std::uint64_t>(options.smooth_passes), "pass", "passes") +
                     ")");
  if (options.thin_to_spacing > 0.0)
    stages.push_back("thinned to " + format_number(options.thin_to_spacing));
  facts.emplace_back("cleaning", stages.empty() ? "none" : joined(stages));
  if (!plan.noise_note.empty()) facts.emplace_back("", plan.noise_note);
  return facts;
}

/// Loops of a mesh that is known from an earlier run: those without a reason are to be filled.
void add_loops(Facts& facts, std::span<const HoleFacts> loops) {
  std::vector<HoleFacts> open;
  for (const HoleFacts& loop : loops) {
    if (!loop.reason.empty()) open.push_back(loop);
  }
  facts.emplace_back("loops", format_count(loops.size()) + " in the mesh of the work directory, " +
                                  format_count(loops.size() - open.size()) + " to be filled");
  for (const auto& [reason, count] : hole_summary(open).reasons)
    facts.emplace_back("", format_count(count) + " left open: " + reason);
}

std::string plan_json(const JobPlan& plan, const FillOptions& fill) {
  const Json document = {
      {"input",
       {{"files", plan.files},
        {"points", plan.points},
        {"points_read", plan.points_read},
        {"points_dropped", plan.points_dropped},
        {"bounds", box_json(plan.bounds)}}},
      {"partition",
       {{"chunks", plan.chunks},
        {"chunk_points", plan.chunk_points},
        {"largest_chunk_points", plan.largest_chunk_points},
        {"halo_width", plan.halo_width},
        {"chunks_in_flight", plan.chunks_in_flight}}},
      {"doubts", plan.doubts},
      {"radii", {{"values", plan.radii}, {"reason", plan.radii_reason}}},
      {"normals",
       {{"source", text_of(plan.normals.source)},
        {"orientation", plan.normals.orientation == Orientation::kAuto
                            ? Json()
                            : Json(text_of(plan.normals.orientation))}}},
      {"cleaning",
       {{"thickness", plan.cleaning.thickness},
        {"outlier_sigma", plan.cleaning.options.outlier_sigma},
        {"merge_tolerance", plan.cleaning.options.merge_tolerance},
        {"smooth_radius", plan.cleaning.options.smooth_radius},
        {"thin_to_spacing", plan.cleaning.options.thin_to_spacing},
        {"reason", plan.cleaning.reason}}},
      {"fill",
       {{"enabled", fill.enabled}, {"left_open", fill.enabled ? Json(left_open(fill)) : Json()}}},
      {"holes", plan.loops ? Json::parse(holes_json(*plan.loops)) : Json()},
      {"peak_memory_bytes", plan.peak_memory_bytes},
      {"disk_bytes", plan.disk_bytes},
      {"seconds", plan.seconds}};
  return json_text(document);
}

/// The note without the words that the row begins with.
std::string radii_of(const JobPlan& plan) {
  const std::size_t figures = plan.radii_note.find_first_of("0123456789");
  return figures == std::string::npos ? plan.radii_reason : plan.radii_note.substr(figures);
}

std::string plan_text(const JobPlan& plan, const Job& job) {
  Facts facts = {{"files", joined(plan.files)},
                 {"points", format_count(plan.points)},
                 {"bounds", show_box(plan.bounds)},
                 {"chunks", format_count(plan.chunks) + " of up to " +
                                counted(plan.largest_chunk_points, "point", "points")},
                 {"in flight", std::to_string(plan.chunks_in_flight)},
                 {"halo width", format_number(plan.halo_width)},
                 {"ball radii", radii_of(plan)}};
  auto below_points = facts.begin() + 2;
  for (const auto& [reason, count] : plan.points_dropped)
    below_points =
        facts.insert(below_points, {"", format_count(count) + " dropped: " + reason}) + 1;
  for (const std::string& doubt : plan.doubts) facts.emplace_back("in doubt", doubt);
  for (const auto& fact : cleaning_plan(plan)) facts.push_back(fact);
  for (const auto& fact : fill_plan(job)) facts.push_back(fact);
  if (plan.loops) add_loops(facts, *plan.loops);
  facts.insert(facts.end(), {{"peak memory", "about " + format_bytes(plan.peak_memory_bytes)},
                             {"disk", "about " + format_bytes(plan.disk_bytes)},
                             {"time", "about " + format_duration(plan.seconds)}});
  return facts_table(facts);
}

/// Where a run would go no further.
void check_places(const Job& job, const std::string& job_file) {
  if (job.output.mesh.empty()) return;
  const std::vector<PathRole> paths = job_paths(job, expand_globs(job.input.files), job_file);
  check_collisions(paths);
  check_output_names(job.output, setting_name(job, "output.report"));
}

void show_plan(const PlanOptions& options, const StopToken& stop) {
  JobArguments arguments = options.job;
  sort_out_scans(arguments);
  const Job job = job_of(arguments);
  check_places(job, arguments.job_file);
  const auto progress = make_progress(progress_style(options.job));
  const JobPlan plan = plan_job(job, *progress, stop);
  std::cout << (options.json ? plan_json(plan, job.fill) : plan_text(plan, job));
}

}  // namespace

void add_plan_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* command =
      program.add_subcommand("plan", "Show what a run would do and need; writes nothing");
  add_job_or_scan_options(*command, options->job);
  add_run_options(*command, options->job);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer(
      "Example:\n  orbweave plan job.toml --memory 2GiB\n  orbweave plan scan.ply --ball-radii "
      "0.001\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { show_plan(*options, stop); });
  });
}

}  // namespace orbweave
