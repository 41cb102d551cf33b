#include "engine/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "engine/cli/commands.h"
#include "engine/cli/output.h"
#include "io/error.h"
#include "io/nearest_name.h"

namespace orbweave {
namespace {

constexpr const char* kVersion = "orbweave " ORBWEAVE_VERSION;

std::vector<std::string> command_names(CLI::App& program) {
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands(nullptr))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

/// Commands come first, options of the program aside: an unknown first word is a misspelt one.
void check_command(CLI::App& program, const std::vector<std::string>& arguments) {
  const std::vector<std::string> names = command_names(program);
  if (arguments.size() < 2)
    throw_usage("no command given",
                {.expected = "one of " + joined(names), .advice = "See 'orbweave --help'."});
  const std::string& word = arguments[1];
  if (word.starts_with("-") || std::find(names.begin(), names.end(), word) != names.end()) return;
  throw_usage("unknown command \"" + word + "\"",
              {.expected = "one of " + joined(names),
               .advice = "Did you mean '" + nearest_name(word, names) + "'?"});
}

std::string help_advice(const CLI::App& program) {
  const auto chosen = program.get_subcommands();
  return "See 'orbweave " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help'.";
}

/// An unknown option explains more than what is missing because of it.
[[noreturn]] void reject_extras(CLI::App& program) {
  const auto chosen = program.get_subcommands();
  CLI::App& command = chosen.empty() ? program : *chosen.front();
  const std::vector<std::string> extras = program.remaining(true);
  const std::string word = extras.empty() ? "" : extras.front().substr(0, extras.front().find('='));
  if (!word.starts_with("-"))
    throw_usage("unexpected argument \"" + word + "\"", {.advice = help_advice(program)});
  throw_usage("unknown option " + word,
              {.advice = "Did you mean " + nearest_name(word, option_names(command)) + "? " +
                         help_advice(program)});
}

[[noreturn]] void reject(const CLI::App& program, std::string problem) {
  while (problem.ends_with('\n') || problem.ends_with('.')) problem.pop_back();
  throw_usage(problem, {.advice = help_advice(program)});
}

/// Runs the parser over the arguments; what they ask for goes to `action`.
void parse(CLI::App& program, const std::vector<std::string>& arguments, CommandAction& action) {
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend() - 1);
  try {
    program.parse(reversed);
  } catch (const CLI::CallForHelp&) {
    action = [help = program.help()] { std::cout << help; };
  } catch (const CLI::CallForVersion&) {
    action = [] { std::cout << kVersion << "\n"; };
  } catch (const CLI::ParseError& error) {
    if (!program.remaining(true).empty()) reject_extras(program);
    reject(program, error.what());
  }
}

}  // namespace

CommandAction parse_command_line(const std::vector<std::string>& arguments, const StopToken& stop) {
  CLI::App program("Turns point clouds of any size into one seamless triangle mesh.", "orbweave");
  program.set_version_flag("--version", kVersion, "Print the version and exit");
  program.get_formatter()->column_width(34);
  program.get_formatter()->label("SUBCOMMAND", "COMMAND");
  program.get_formatter()->label("REQUIRED", "(required)");
  program.footer("Example:\n  orbweave reconstruct scan.ply -o mesh.ply\n");
  CommandAction action;
  const CommandContext context{arguments, stop,
                               [&action](CommandAction chosen) { action = std::move(chosen); }};
  add_run_command(program, context);
  add_reconstruct_command(program, context);
  add_fill_command(program, context);
  add_plan_command(program, context);
  add_status_command(program, context);
  add_inspect_command(program, context);
  add_compare_command(program, context);
  add_convert_command(program, context);
  add_generate_command(program, context);
  for (CLI::App* command : program.get_subcommands(nullptr)) command->group("Commands");
  program.require_subcommand(1);
  check_command(program, arguments);
  parse(program, arguments, action);
  return action;
}

}  // namespace orbweave
