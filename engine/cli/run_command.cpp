// orbweave run and orbweave reconstruct: a job, from a job file or from the command line.
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "engine/cli/commands.h"
#include "engine/cli/failure.h"
#include "engine/cli/freed_memory.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/pipeline/job_paths.h"
#include "engine/pipeline/output/mesh_name.h"
#include "engine/pipeline/output/output_files.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/stage/method_costs.h"
#include "io/error.h"
#include "io/job/output_origin.h"
#include "io/job/simplified_file.h"
#include "io/meshes/shift_file.h"
#include "io/shown_text.h"
#include "io/system/glob.h"
#include "io/text/quantity.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

std::string summary(const RunReport& report) {
  const OutputOptions& output = report.options.output;
  if (report.ended_before) {
    Facts facts = {{"mesh", output.mesh}, {"", "whole, as an earlier run of this job wrote it"}};
    const std::string work_dir = work_dir_of(report.options);
    std::error_code ignored;
    if (!std::filesystem::exists(work_dir, ignored))
      facts.emplace_back("", work_dir + ", the work directory that it left, is removed");
    return facts_table(facts);
  }
  Facts facts;
  Facts beside;  // what lies beside the mesh
  const BesideMesh files{!report.coordinate_system.empty(), report.origin != Vec3{},
                         origin_beside(simplified_file(output)) != Vec3{}};
  for (const OutputFile& written : written_outputs(output, files)) {
    Facts& list = facts.empty() ? facts : beside;
    list.emplace_back(written.role, written.file.string());
  }
  facts.emplace_back("", show_mesh(report.mesh));
  for (const OutputFile& older : older_outputs(output, !report.coordinate_system.empty()))
    facts.emplace_back("", older.file.string() + " is not of this run");
  add_dropped(facts, report.points_dropped);
  if (!has_own_vertices(report.options.reconstruct.method)) add_unused(facts, report.points_unused);
  add_removed(facts, report.pieces_removed, report.triangles_removed);
  add_holes(facts, report.holes, report.mesh, report.options);
  if (report.origin != Vec3{}) facts.emplace_back("origin", origin_text(report.origin));
  facts.insert(facts.end(), beside.begin(), beside.end());
  return facts_table(facts);
}

/// Says what remains of the work, where an interruption or a lack of something leaves any.
/// `kept`: what is written and what resumes.
[[noreturn]] void rethrow_with_work_dir(const Error& error, const std::string& work_dir,
                                        const std::string& kept, const RunWatch& watch,
                                        const Communicator& communicator) {
  const bool interrupted = error.kind() == ErrorKind::kInterrupted;
  std::error_code ignored;
  if (!std::filesystem::exists(work_dir, ignored)) throw;
  // One process removes it; of several, others may still be at work there.
  if (error.kind() == ErrorKind::kBadInput && communicator.size() > 1 && watch.work_dir_is_opened)
    throw Error(
        error.kind(), error.what(),
        {.advice = watch.work_dir_is_made ? "The work directory " + work_dir + " stays; remove it."
                                          : "What the job wrote in " + work_dir + " stays."});
  if (!interrupted && error.kind() != ErrorKind::kResource) throw;
  // mpirun ends the others of a job by the signal that users interrupt it with.
  const char* const interruption = communicator.size() == 1
                                       ? "interrupted"
                                       : "interrupted, by a signal or by the end of another rank";
  throw Error(error.kind(), interrupted ? interruption : error.what(), {.advice = kept});
}

/// All that can be known to go wrong before the work.
void check_outputs(const JobArguments& arguments, const Job& job) {
  const OutputOptions& output = job.output;
  if (output.mesh.empty())
    throw_usage("names no mesh to write",
                {.file = arguments.job_file, .expected = "[output] mesh = \"mesh.ply\""});
  check_mesh_name(output);
  check_job_paths(job, expand_globs(job.input.files), arguments.job_file);
}

/// TBB takes no more threads than there are cores; more are used when they are asked for.
tbb::global_control allow_threads(int threads) {
  return {tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)};
}

/// Members that do not lead are silent.
void run(const JobArguments& arguments, const CommandContext& context) {
  const Job job = job_of(arguments);
  check_outputs(arguments, job);
  const int threads = std::max(job.run.threads, available_threads());
  keep_freed_memory(job.partition.memory_bytes, threads);
  const tbb::global_control control = allow_threads(threads);
  const bool leads = context.communicator.is_root();
  const std::string work_dir = work_dir_of(job);
  promise_to_resume();
  // All that a member has to say its leader says.
  std::string kept = "What is done is kept in " + work_dir + "; the same command resumes.";
  const auto promise = [&] { set_last_word(leads ? "interrupted. " + shown(kept) : ""); };
  promise();
  RunWatch watch;
  watch.at_mesh_written = [&] {
    if (job.output.mesh == "-") return;
    kept = "The mesh is complete, other outputs are not. " + kept;
    promise();
  };
  watch.at_outputs_written = [&] {
    kept = "All outputs are written.";
    set_last_word(leads ? "interrupted when all outputs were written. The same command removes " +
                              shown(work_dir) + "."
                        : "");
  };
  const auto progress = make_progress(leads ? progress_style(arguments) : ProgressStyle::kSilent);
  try {
    const RunReport report =
        run_job(job, context.arguments, *progress, context.stop, context.communicator, &watch);
    // Not in the summary: standard output is the same for the same mesh.
    if (leads && !report.ended_before)
      progress->note("done in " + format_duration(report.measured.seconds) + ", peak memory " +
                     format_bytes(report.measured.peak_memory_bytes));
    if (leads && job.output.mesh != "-") std::cout << summary(report);
  } catch (const Error& error) {
    rethrow_with_work_dir(error, work_dir, kept, watch, context.communicator);
  }
}

void run_when_asked(CLI::App& command, const std::shared_ptr<JobArguments>& arguments,
                    const CommandContext& context) {
  command.callback(
      [arguments, context] { context.then([arguments, context] { run(*arguments, context); }); });
}

std::string example(const CLI::App& program, const std::string& arguments) {
  const std::string& name = program.get_name();
  return "An interrupted run resumes with the same command.\n\nExample:\n  " +
         (name == "orbweave" ? name : "mpirun -n 8 " + name) + " " + arguments + "\n";
}

}  // namespace

void add_run_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<JobArguments>();
  CLI::App* command = program.add_subcommand("run", "Run a job: scans in, one mesh out");
  add_job_file_options(*command, *arguments);
  add_run_options(*command, *arguments);
  command->footer(example(program, "run job.toml --set reconstruct.levels=3 --memory 2GiB"));
  run_when_asked(*command, arguments, context);
}

void add_reconstruct_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<JobArguments>();
  CLI::App* command =
      program.add_subcommand("reconstruct", "Make a mesh of scans: a job without a job file");
  add_all_key_options(*command, *arguments);
  add_run_options(*command, *arguments);
  command->footer(
      example(program, "reconstruct scan.ply -o mesh.ply --ball-radii 0.001,0.002 --memory 2GiB"));
  run_when_asked(*command, arguments, context);
}

}  // namespace orbweave
