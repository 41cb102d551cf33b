#include "engine/cli/command_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>

namespace orbweave {
namespace {

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// "a" and "b" of "WORD:{a,b}".
std::vector<std::string> choices_in(const std::string& value) {
  std::vector<std::string> choices;
  const std::size_t open = value.find('{'), close = value.rfind('}');
  if (open == std::string::npos || close == std::string::npos) return choices;
  for (std::size_t begin = open + 1; begin < close;) {
    const std::size_t end = std::min(value.find(',', begin), close);
    choices.push_back(value.substr(begin, end - begin));
    begin = end + 1;
  }
  return choices;
}

OptionFacts option_facts(const CLI::Option& option) {
  OptionFacts facts;
  for (const std::string& name : option.get_snames()) facts.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) facts.names.push_back("--" + name);
  facts.is_argument = facts.names.empty();
  if (facts.is_argument) facts.names.push_back(option.get_name(true));
  if (option.get_items_expected_max() > 0) facts.value = option.get_type_name();
  facts.choices = choices_in(facts.value);
  facts.help = one_line(option.get_description());
  facts.is_required = option.get_required();
  return facts;
}

void add_options(const CLI::App& command, std::vector<OptionFacts>& options) {
  for (const CLI::Option* option : command.get_options())
    if (!option->get_group().empty()) options.push_back(option_facts(*option));
}

}  // namespace

ProgramFacts program_facts(const CLI::App& program) {
  ProgramFacts facts{.name = program.get_name(),
                     .help = one_line(program.get_description()),
                     .example = program.get_footer()};
  add_options(program, facts.options);
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    facts.commands.push_back({.name = command->get_name(),
                              .help = one_line(command->get_description()),
                              .example = command->get_footer()});
    add_options(*command, facts.commands.back().options);
  }
  return facts;
}

}  // namespace orbweave
