#include "engine/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <span>

#include "engine/cli/commands.h"
#include "engine/cli/output.h"
#include "engine/cli/team_program.h"
#include "engine/pipeline/surface/in_core_methods.h"
#include "io/error.h"
#include "io/job/job_keys.h"
#include "io/text/nearest_name.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

constexpr const char* kVersion = " " ORBWEAVE_VERSION;

/// What --version prints after the name: the number and, where parts of the program ask for another
/// licence than its own, that.
std::string version_text() {
  return kVersion + std::string(has_voronoi_family()
                                    ? "\nBuilt with the Voronoi family, on CGAL: distributed under "
                                      "the GPL, version 3 or later"
                                    : "");
}

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
    throw_usage("no command given", {.expected = "one of " + joined(names),
                                     .advice = "See '" + program.get_name() + " --help'."});
  const std::string& word = arguments[1];
  if (word.starts_with("-") || std::find(names.begin(), names.end(), word) != names.end()) return;
  throw_usage("unknown command \"" + word + "\"",
              {.expected = "one of " + joined(names), .advice = advice_on_name(word, names)});
}

std::string help_advice(const CLI::App& program) {
  const auto chosen = program.get_subcommands();
  return "See '" + program.get_name() + " " +
         (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help'.";
}

/// What to write in the place of an option of `reconstruct` where a job file is run; empty:
/// nothing.
std::string advice_on_key(CLI::App& command, const std::string& option) {
  if (command.get_option_no_throw("--set") == nullptr) return {};
  for (const JobKey& key : job_keys()) {
    if (std::string("--") + key.option != option) continue;
    const std::string value = key.option_value;
    return "Give a key of the job another value by --set " + key.name() + "=" +
           (value.empty() ? "VALUE" : value) + ". ";
  }
  return {};
}

/// What the commands did not take, but for the "--" that ends the options.
std::vector<std::string> extras_of(const CLI::App& program) {
  std::vector<std::string> extras = program.remaining(true);
  std::erase(extras, "--");
  return extras;
}

/// An unknown option explains more than what is missing because of it.
[[noreturn]] void reject_extras(CLI::App& program) {
  const auto chosen = program.get_subcommands();
  CLI::App& command = chosen.empty() ? program : *chosen.front();
  const std::vector<std::string> extras = extras_of(program);
  const std::string word = extras.empty() ? "" : extras.front().substr(0, extras.front().find('='));
  if (!word.starts_with("-"))
    throw_usage("unexpected argument \"" + word + "\"", {.advice = help_advice(program)});
  if (const std::string advice = advice_on_key(command, word); !advice.empty())
    throw_usage("unknown option " + word, {.advice = advice + help_advice(program)});
  const std::string nearest = nearest_name(word, option_names(command));
  throw_usage(
      "unknown option " + word,
      {.advice = (nearest.empty() ? "" : "Did you mean " + nearest + "? ") + help_advice(program)});
}

[[noreturn]] void reject(const CLI::App& program, std::string problem) {
  while (problem.ends_with('\n') || problem.ends_with('.')) problem.pop_back();
  std::ranges::replace(problem, '\n', ' ');
  throw_usage(problem, {.advice = help_advice(program)});
}

/// Whether a word is an option that takes a value and has an empty one: "--name=".
bool is_empty_option(CLI::App& program, const std::string& command, const std::string& word) {
  if (!word.starts_with("--") || word.find('=') + 1 != word.size()) return false;
  const auto chosen = program.get_subcommands(
      [&command](const CLI::App* each) { return each->get_name() == command; });
  if (chosen.empty()) return false;
  const CLI::Option* const option =
      chosen.front()->get_option_no_throw(word.substr(0, word.size() - 1));
  return option != nullptr && option->get_items_expected_min() > 0;
}

/// The arguments behind the program's name, the last one first, as the parser takes them. An empty
/// value becomes a word of its own: else the parser takes the next option for the value.
std::vector<std::string> parsed_words(CLI::App& program,
                                      const std::vector<std::string>& arguments) {
  std::vector<std::string> words;
  bool are_options = true;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    are_options = are_options && word != "--";
    const bool is_empty = are_options && is_empty_option(program, arguments[1], word);
    words.push_back(is_empty ? word.substr(0, word.size() - 1) : word);
    if (is_empty) words.emplace_back();
  }
  std::reverse(words.begin(), words.end());
  return words;
}

/// A shell variable that is not set leaves an empty name behind.
void check_names(const CLI::App& program) {
  for (const CLI::App* command : program.get_subcommands())
    for (const CLI::Option* option : command->get_options()) {
      if (!option->get_positional()) continue;
      const std::vector<std::string>& words = option->results();
      if (std::find(words.begin(), words.end(), "") != words.end())
        throw_usage(option->get_name() + ": the name is empty",
                    {.advice = "Where a variable of the shell holds the name, see whether it is "
                               "set. " +
                               help_advice(program)});
    }
}

/// Runs the parser over the arguments; what they ask for goes to `action`.
void parse(CLI::App& program, const CommandContext& context) {
  const auto show = [&context](const std::string& text) {
    context.then([text, leads = context.communicator.is_root()] {
      if (leads) std::cout << text;
    });
  };
  try {
    program.parse(parsed_words(program, context.arguments));
    check_names(program);
  } catch (const CLI::CallForHelp&) {
    show(program.help());
  } catch (const CLI::CallForVersion&) {
    show(program.get_name() + version_text() + "\n");
  } catch (const CLI::ParseError& error) {
    if (!extras_of(program).empty()) reject_extras(program);
    reject(program, error.what());
  }
}

using AddCommand = void (*)(CLI::App&, const CommandContext&);

/// The action that `program` comes to with these commands.
CommandAction action_of(CLI::App& program, std::span<const AddCommand> commands,
                        const std::vector<std::string>& arguments, const StopToken& stop,
                        Communicator& communicator) {
  program.set_version_flag("--version", program.get_name() + version_text(),
                           "Print the version and exit");
  program.get_formatter()->column_width(34);
  program.get_formatter()->label("SUBCOMMAND", "COMMAND");
  program.get_formatter()->label("REQUIRED", "(required)");
  CommandAction action;
  const CommandContext context{arguments, stop, communicator,
                               [&action](CommandAction chosen) { action = std::move(chosen); }};
  for (const AddCommand add : commands) add(program, context);
  for (CLI::App* command : program.get_subcommands(nullptr)) command->group("Commands");
  program.require_subcommand(1);
  check_command(program, arguments);
  parse(program, context);
  return action;
}

}  // namespace

CommandAction parse_command_line(const std::vector<std::string>& arguments, const StopToken& stop) {
  static Communicator alone;
  constexpr std::array<AddCommand, 13> kCommands = {
      add_run_command,      add_reconstruct_command, add_fill_command,    add_plan_command,
      add_status_command,   add_inspect_command,     add_compare_command, add_convert_command,
      add_simplify_command, add_tileset_command,     add_view_command,    add_generate_command,
      add_config_command};
  CLI::App program("Turns point clouds of any size into one seamless triangle mesh.", "orbweave");
  program.footer("Example:\n  orbweave reconstruct scan.ply -o mesh.ply\n");
  return action_of(program, kCommands, arguments, stop, alone);
}

CommandAction parse_team_command_line(const std::vector<std::string>& arguments,
                                      const StopToken& stop, Communicator& communicator) {
  constexpr std::array<AddCommand, 2> kCommands = {add_run_command, add_reconstruct_command};
  static_assert(kCommands.size() == kTeamCommands.size());
  CLI::App program(kTeamHelp, kTeamProgram);
  program.footer(kTeamExample);
  return action_of(program, kCommands, arguments, stop, communicator);
}

}  // namespace orbweave
