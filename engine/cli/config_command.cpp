// orbweave config: job files, their schema and their keys, from the table that parses them.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/cli/commands.h"
#include "engine/cli/json_text.h"
#include "io/error.h"
#include "io/job/job_defaults.h"
#include "io/job/job_reference.h"
#include "io/job/job_schema.h"

namespace orbweave {
namespace {

struct ConfigOptions {
  bool defaults = false;
  bool schema = false;
  bool reference = false;
};

std::string config_text(const ConfigOptions& options) {
  if (options.defaults) return commented_job_file();
  if (options.schema) return json_text(job_schema());
  if (options.reference) return job_key_reference();
  throw_usage("nothing asked for", {.expected = "--defaults, --schema or --reference",
                                    .advice = "See 'orbweave config --help'."});
}

}  // namespace

void add_config_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* command = program.add_subcommand(
      "config", "Print a job file with every key and its default, or what describes job files");
  CLI::Option_group* what = command->add_option_group("What");
  what->add_flag("--defaults", options->defaults,
                 "A job file with every key, explained, at its default");
  what->add_flag("--schema", options->schema,
                 "The JSON schema of job files, for editors and programs that write them");
  what->add_flag("--reference", options->reference, "All keys as a page (Markdown)");
  what->require_option(0, 1);
  command->footer(
      "Example:\n"
      "  orbweave config --defaults > job.toml\n"
      "  orbweave config --schema > orbweave.schema.json\n");
  command->callback(
      [options, context] { context.then([options] { std::cout << config_text(*options); }); });
}

}  // namespace orbweave
