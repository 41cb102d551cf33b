#include "engine/cli/job_arguments.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "engine/cli/file_kind.h"
#include "io/error.h"
#include "io/job/job_file.h"

namespace orbweave {
namespace {

/// Keys that `run` and `plan` have options for; --set reaches all others.
constexpr std::array<std::string_view, 7> kRunKeys = {
    "partition.memory", "output.report", "output.picture",   "output.tileset",
    "run.threads",      "run.work_dir",  "run.keep_work_dir"};

constexpr std::string_view kMeshKey = "output.mesh";

/// What an option takes, as help shows it: the values of a choice, a word for other types.
std::string value_name(const JobKey& key) {
  std::string names;
  for (const char* const choice : key.choices)
    names += std::string(names.empty() ? "{" : ",") + choice;
  if (!names.empty()) return names + "}";
  switch (key.type) {
    case JobKeyType::kTexts:
      return "NAME,...";
    case JobKeyType::kPath:
      return "FILE";
    case JobKeyType::kDirectory:
      return "DIR";
    case JobKeyType::kPaths:
      return "FILE,...";
    case JobKeyType::kNumber:
      return "X";
    case JobKeyType::kNumbers:
      return "X,X,...";
    case JobKeyType::kSimplification:
      return "LIMIT=X";
    case JobKeyType::kColor:
      return "#RRGGBB";
    case JobKeyType::kBytes:
      return "BYTES";
    case JobKeyType::kInteger:
      return "N";
    default:
      return "WORD";
  }
}

std::string capitalised(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z')
    text[0] = static_cast<char>(text[0] - 'a' + 'A');
  return text;
}

std::string unquoted(const std::string& text) {
  std::string bare;
  for (const char c : text)
    if (c != '"') bare += c;
  return bare;
}

/// Options that switch a key off and say more plainly what happens then.
struct NegatedOption {
  std::string_view option;
  std::string_view help;
};
constexpr std::array<NegatedOption, 2> kNegatedOptions = {
    {{"close-outer-border", "Fill the outer border of an open sheet, too"},
     {"uniform-patches",
      "Make triangles in the middle of a large patch as small as along its rim"}}};

/// A list without its brackets, and whole numbers without the point that TOML needs.
std::string plain_list(const std::string& list) {
  std::string plain;
  for (std::size_t i = 1; i + 1 < list.size(); ++i) {
    const bool ends_whole =
        list.compare(i, 2, ".0") == 0 && (list[i + 2] == ',' || list[i + 2] == ']');
    if (ends_whole) ++i;
    if (!ends_whole && list[i] != ' ') plain += list[i];
  }
  return plain;
}

std::string help_of(const JobKey& key) {
  for (const NegatedOption& known : kNegatedOptions)
    if (known.option == key.option) return std::string(known.help);
  if (std::string_view(key.option_value) == "false") return std::string("Do not ") + key.help;
  const bool is_list = key.type == JobKeyType::kNumbers && key.default_text().starts_with('[');
  const std::string usual = is_list ? plain_list(key.default_text()) : unquoted(key.default_text());
  const bool shown = *key.option_value == '\0' && !usual.empty() && usual != "[]";
  return capitalised(key.help) + (shown ? " [" + usual + "]" : "");
}

/// Former names of options. Scripts may use them; help does not show them.
struct FormerOption {
  std::string_view former;
  std::string_view option;
  const char* value = nullptr;  ///< of a flag, where it is not what the option of today sets
};
constexpr std::array<FormerOption, 3> kFormerOptions = {
    {{"radii", "ball-radii"},
     {"clean", "cleaning"},
     {"no-intersections", "allow-intersections", "false"}}};

CLI::Option* add_key_option(CLI::App& command, const JobKey& key, const std::string& option,
                            JobArguments& arguments, const char* value = nullptr) {
  const auto set = [&arguments, name = key.name()](const std::string& text) {
    arguments.settings.emplace_back(name, text);
  };
  if (*key.option_value != '\0') {
    return command.add_flag_function(
        option,
        [set, text = std::string(value != nullptr ? value : key.option_value)](std::int64_t) {
          set(text);
        },
        help_of(key));
  }
  return command.add_option_function<std::string>(option, set, help_of(key))
      ->type_name(value_name(key));
}

CLI::Option* add_key_option(CLI::App& command, const JobKey& key, JobArguments& arguments) {
  for (const FormerOption& known : kFormerOptions)
    if (known.option == key.option)
      add_key_option(command, key, "--" + std::string(known.former), arguments, known.value)
          ->group("");
  const std::string short_option = key.name() == kMeshKey ? "-o," : "";
  return add_key_option(command, key, short_option + "--" + key.option, arguments);
}

void add_assignments(CLI::App& command, JobArguments& arguments) {
  command
      .add_option("--set", arguments.assignments,
                  "Set a key of the job file, overriding it; may be given many times")
      ->type_name("SECTION.KEY=VALUE")
      ->expected(1)
      ->take_all();
}

/// By its name: what is read as a cloud, standard input, and patterns, which job files have no use
/// for. A file may lie in a folder whose name looks like one.
bool is_scan_name(const std::string& name) {
  if (name == "-" || is_scan_format(name)) return true;
  std::error_code ignored;
  return name.find_first_of("*?[") != std::string::npos && !std::filesystem::exists(name, ignored);
}

}  // namespace

void add_job_file_options(CLI::App& command, JobArguments& arguments) {
  command.add_option("JOB", arguments.job_file, "The job file (TOML)")->type_name("")->required();
  add_assignments(command, arguments);
  add_key_options(command, kRunKeys, arguments);
}

void add_job_or_scan_options(CLI::App& command, JobArguments& arguments) {
  command.add_option("JOB|SCAN", arguments.scans, "The job file (TOML), or scans without one")
      ->type_name("")
      ->required();
  add_assignments(command, arguments);
  for (const JobKey& key : job_keys())
    if (*key.option != '\0') add_key_option(command, key, arguments);
}

void sort_out_scans(JobArguments& arguments) {
  std::vector<std::string>& names = arguments.scans;
  const auto job_file = std::find_if_not(names.begin(), names.end(), is_scan_name);
  if (job_file == names.end()) return;
  if (names.size() > 1)
    throw_usage("a job file or scans, not both", {.file = *job_file,
                                                  .found = std::to_string(names.size()) + " names",
                                                  .expected = "JOB.toml, or SCAN..."});
  arguments.job_file = *job_file;
  names.clear();
}

void add_all_key_options(CLI::App& command, JobArguments& arguments) {
  command.add_option("SCAN", arguments.scans, "Scans, as paths and patterns")
      ->type_name("")
      ->required();
  for (const JobKey& key : job_keys())
    if (*key.option != '\0')
      add_key_option(command, key, arguments)->required(key.name() == kMeshKey);
}

void add_key_options(CLI::App& command, std::span<const std::string_view> names,
                     JobArguments& arguments) {
  for (const JobKey& key : job_keys())
    if (std::ranges::find(names, key.name()) != names.end())
      add_key_option(command, key, arguments)->required(key.name() == kMeshKey);
}

void add_run_options(CLI::App& command, JobArguments& arguments) {
  command.add_flag("--fresh", arguments.fresh,
                   "Start over: drop what an interrupted run left in the work directory");
  add_progress_option(command, arguments);
}

void add_progress_option(CLI::App& command, JobArguments& arguments) {
  command
      .add_option("--progress", arguments.progress,
                  "auto (live on a terminal), plain (lines for a log) or none (warnings alone)")
      ->check(CLI::IsMember({"auto", "plain", "none"}))
      ->type_name("WORD");
}

Job job_of(const JobArguments& arguments) {
  if (is_scan_name(arguments.job_file))
    throw_usage("is a scan, where a job file is wanted",
                {.file = arguments.job_file,
                 .expected = "JOB.toml",
                 .advice = "Scans without a job file: orbweave reconstruct SCAN... -o mesh.ply"});
  Job job = arguments.job_file.empty() ? Job{} : read_job_file(arguments.job_file);
  if (!arguments.scans.empty()) job.input.files = arguments.scans;
  for (const std::string& assignment : arguments.assignments) set_job_key(job, assignment);
  for (const auto& [key, text] : arguments.settings) set_job_option(job, key, text);
  job.run.is_from_command_line = arguments.job_file.empty();
  job.run.fresh = arguments.fresh;
  if (job.input.files.empty())
    throw_usage("names no scans",
                {.file = arguments.job_file, .expected = "[input] files = [\"scan.ply\"]"});
  if (std::ranges::find(job.input.files, "-") != job.input.files.end())
    throw_usage("a job reads its scans several times and takes none from standard input",
                {.file = arguments.job_file,
                 .place = arguments.job_file.empty() ? "" : "input.files",
                 .advice = "Write a file first: orbweave convert - scan.ply"});
  return job;
}

Job settings_of(const JobArguments& arguments) {
  Job job;
  for (const auto& [key, text] : arguments.settings) set_job_option(job, key, text);
  job.run.is_from_command_line = true;
  return job;
}

ProgressStyle progress_style(const JobArguments& arguments) {
  if (arguments.progress == "plain") return ProgressStyle::kPlain;
  return arguments.progress == "none" ? ProgressStyle::kNone : ProgressStyle::kAuto;
}

}  // namespace orbweave
