// orbweave plan: what a run would do.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/cli/commands.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/pipeline/pipeline.h"
#include "io/quantity.h"

namespace orbweave {
namespace {

struct PlanOptions {
  JobArguments job;
  bool json = false;
};

std::string plan_json(const JobPlan& plan) {
  const nlohmann::ordered_json document = {
      {"input",
       {{"files", plan.files}, {"points", plan.points}, {"bounds", box_json(plan.bounds)}}},
      {"partition",
       {{"chunks", plan.chunks},
        {"chunk_points", plan.chunk_points},
        {"largest_chunk_points", plan.largest_chunk_points},
        {"halo_width", plan.halo_width},
        {"chunks_in_flight", plan.chunks_in_flight}}},
      {"radii", {{"values", plan.radii}, {"reason", plan.radii_reason}}},
      {"peak_memory_bytes", plan.peak_memory_bytes},
      {"disk_bytes", plan.disk_bytes},
      {"seconds", plan.seconds}};
  return json_text(document);
}

std::string plan_text(const JobPlan& plan) {
  return facts_table({{"files", joined(plan.files)},
                      {"points", format_count(plan.points)},
                      {"bounds", show_box(plan.bounds)},
                      {"chunks", format_count(plan.chunks) + " of up to " +
                                     format_count(plan.largest_chunk_points) + " points"},
                      {"in flight", std::to_string(plan.chunks_in_flight)},
                      {"halo width", format_number(plan.halo_width)},
                      {"radii", show_list(plan.radii)},
                      {"reason", plan.radii_reason},
                      {"peak memory", "about " + format_bytes(plan.peak_memory_bytes)},
                      {"disk", "about " + format_bytes(plan.disk_bytes)},
                      {"time", "about " + format_duration(plan.seconds)}});
}

void show_plan(const PlanOptions& options, const StopToken& stop) {
  const Job job = job_of(options.job);
  const auto progress = make_progress(progress_style(options.job));
  const JobPlan plan = plan_job(job, *progress, stop);
  std::cout << (options.json ? plan_json(plan) : plan_text(plan));
}

}  // namespace

void add_plan_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* command =
      program.add_subcommand("plan", "Show what a run would do and need; writes nothing");
  add_job_file_options(*command, options->job);
  add_run_options(*command, options->job);
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  orbweave plan job.toml --memory 2GiB\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { show_plan(*options, stop); });
  });
}

}  // namespace orbweave
