// orbweave config: job files, their schema and their keys, from the table that parses them.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/cli/command_table.h"
#include "engine/cli/commands.h"
#include "engine/cli/json_text.h"
#include "engine/cli/manual_page.h"
#include "engine/cli/reference_page.h"
#include "engine/cli/shell_completion.h"
#include "io/error.h"
#include "io/job/job_defaults.h"
#include "io/job/job_schema.h"

namespace orbweave {
namespace {

struct ConfigOptions {
  bool defaults = false;
  bool schema = false;
  bool reference = false;
  std::string manual;      ///< name of a page
  std::string completion;  ///< name of a shell
};

/// How many things are asked for.
int asked_for(const ConfigOptions& options) {
  return int{options.defaults} + int{options.schema} + int{options.reference} +
         int{!options.manual.empty()} + int{!options.completion.empty()};
}

std::string config_text(const ConfigOptions& options, const ProgramFacts& program) {
  if (asked_for(options) != 1)
    throw_usage(asked_for(options) == 0 ? "nothing asked for" : "more than one thing asked for",
                {.expected = "--defaults, --schema, --reference, --manual or --completion",
                 .advice = "See 'orbweave config --help'."});
  if (options.defaults) return commented_job_file();
  if (options.schema) return json_text(job_schema());
  if (options.reference) return reference_page(program);
  if (!options.manual.empty()) return manual_page(program, options.manual);
  return shell_completion(program, options.completion);
}

}  // namespace

void add_config_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* command = program.add_subcommand(
      "config", "Print a job file with every key and its default, or what describes job files");
  command->add_flag("--defaults", options->defaults,
                    "A job file with every key, explained, at its default");
  command->add_flag("--schema", options->schema,
                    "The JSON schema of job files, for editors and programs that write them");
  command->add_flag(
      "--reference", options->reference,
      "All keys, options, exit statuses and fields of reports as one page (Markdown)");
  command
      ->add_option("--manual", options->manual,
                   "The manual page of that name, for man: orbweave, orbweave-run, ...")
      ->type_name("PAGE");
  command
      ->add_option("--completion", options->completion, "Completion of command lines for a shell")
      ->type_name("{bash,zsh,fish}");
  command->footer(
      "Example:\n"
      "  orbweave config --defaults > job.toml\n"
      "  orbweave config --schema > orbweave.schema.json\n"
      "  source <(orbweave config --completion bash)\n");
  // The parser is gone when the action runs: the table of its commands is taken before.
  command->callback([options, context, &program] {
    context.then(
        [options, facts = program_facts(program)] { std::cout << config_text(*options, facts); });
  });
}

}  // namespace orbweave
