// Jobs on the command line: the options that set job-file keys, and the job they come to.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/job/job.h"
#include "io/report/progress.h"

namespace CLI {
class App;
}

namespace orbweave {

/// What was given. Settings are (key, text) pairs in the order they win over each other: a later
/// one over an earlier one, all over the job file.
struct JobArguments {
  std::string job_file;                                       ///< empty: a job without a job file
  std::vector<std::string> scans;                             ///< paths and patterns
  std::vector<std::string> assignments;                       ///< "section.key=value"
  std::vector<std::pair<std::string, std::string>> settings;  ///< after the assignments
  bool fresh = false;
  std::string progress = "auto";
};

/// JOB.toml, --set, and the options that a run is likely to need; `arguments` must outlive
/// the parsing.
void add_job_file_options(CLI::App& command, JobArguments& arguments);
/// JOB.toml or SCAN..., --set, and an option for every key of the job file that has one, none of
/// them needed. After the parsing sort_out_scans() tells job file and scans apart.
void add_job_or_scan_options(CLI::App& command, JobArguments& arguments);
/// Scans go by their extension or a pattern; anything else is a job file. Throws Error (usage)
/// where both are given.
void sort_out_scans(JobArguments& arguments);
/// SCAN..., -o, and an option for every key of the job file that has one.
void add_all_key_options(CLI::App& command, JobArguments& arguments);
/// Options for the keys of these names ("fill.kernel").
void add_key_options(CLI::App& command, std::span<const std::string_view> names,
                     JobArguments& arguments);
/// --fresh and --progress.
void add_run_options(CLI::App& command, JobArguments& arguments);
/// --progress alone, for commands that leave nothing to resume from.
void add_progress_option(CLI::App& command, JobArguments& arguments);

/// The job: file, assignments, settings. Throws Error (usage) where one of them is wrong, where
/// no scan is named, and for a scan in the place of a job file.
Job job_of(const JobArguments& arguments);
/// The defaults with the settings alone, for commands that read no scans.
Job settings_of(const JobArguments& arguments);
ProgressStyle progress_style(const JobArguments& arguments);

}  // namespace orbweave
