// orbweave run and orbweave reconstruct: a job, from a job file or from the command line.
#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "engine/cli/commands.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/output_checks.h"
#include "engine/pipeline/pipeline.h"
#include "io/error.h"
#include "io/glob.h"

namespace orbweave {
namespace {

std::string summary(const RunReport& report) {
  const OutputOptions& output = report.options.output;
  if (report.ended_before)
    return facts_table(
        {{"mesh", output.mesh},
         {"", "whole: the run before was killed only when it cleared away its work"}});
  Facts facts = {{"mesh", output.mesh}, {"", show_mesh(report.mesh)}};
  add_holes(facts, report.holes);
  if (!output.report.empty()) facts.emplace_back("report", output.report);
  if (!output.picture.empty()) facts.emplace_back("picture", output.picture);
  return facts_table(facts);
}

/// Says what remains of the work, where an interruption or a lack of something leaves any.
[[noreturn]] void rethrow_with_work_dir(const Error& error, const std::string& work_dir,
                                        const Team& team) {
  const bool interrupted = error.status() == ExitStatus::kInterrupted;
  std::error_code ignored;
  if (!(interrupted || error.status() == ExitStatus::kResource) ||
      !std::filesystem::exists(work_dir, ignored))
    throw;
  // mpirun ends the others of a job by the signal that users interrupt it with.
  const char* const interruption =
      team.size() == 1 ? "interrupted" : "interrupted, by a signal or by the end of another rank";
  throw Error(error.status(), interrupted ? interruption : error.what(),
              {.advice = "What is done is kept in " + work_dir + "; the same command resumes."});
}

/// The mesh's folder is the pipeline's concern.
void check_outputs(const JobArguments& arguments, const Job& job) {
  const OutputOptions& output = job.output;
  if (output.mesh.empty())
    throw_usage("names no mesh to write",
                {.file = arguments.job_file, .expected = "[output] mesh = \"mesh.ply\""});
  check_mesh_name(output.mesh);
  for (const std::string& scan : expand_globs(job.input.files))
    check_input_is_kept(scan, {output.mesh, output.report, output.picture}, "a scan of the job");
  check_folder_of(output.report);
  check_folder_of(output.picture);
}

/// Members that do not lead are silent.
void run(const JobArguments& arguments, const CommandContext& context) {
  const Job job = job_of(arguments);
  check_outputs(arguments, job);
  const bool leads = context.team.leads();
  const auto progress = make_progress(leads ? progress_style(arguments) : ProgressStyle::kNone);
  try {
    const RunReport report = run_job(job, context.arguments, *progress, context.stop, context.team);
    if (leads && job.output.mesh != "-") std::cout << summary(report);
  } catch (const Error& error) {
    rethrow_with_work_dir(error, work_dir_of(job), context.team);
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
      example(program, "reconstruct scan.ply -o mesh.ply --radii 0.001,0.002 --memory 2GiB"));
  run_when_asked(*command, arguments, context);
}

}  // namespace orbweave
