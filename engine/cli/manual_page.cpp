#include "engine/cli/manual_page.h"

#include <algorithm>
#include <string_view>

#include "engine/cli/exit_status.h"
#include "engine/cli/output.h"
#include "engine/cli/team_program.h"
#include "io/error.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

/// Text as roff takes it: a backslash and a dash are none of its commands then.
std::string roff(std::string_view text) {
  std::string escaped;
  bool begins_line = true;
  for (const char c : text) {
    if (begins_line && (c == '.' || c == '\'')) escaped += "\\&";
    if (c == '\\')
      escaped += "\\(rs";
    else if (c == '-')
      escaped += "\\-";
    else if (c == '\'')
      escaped += "\\(aq";
    else if (c == '"' || c == '^' || c == '~' || c == '`')
      escaped += c == '"' ? "\\(dq" : c == '^' ? "\\(ha" : c == '~' ? "\\(ti" : "\\(ga";
    else
      escaped += c;
    begins_line = c == '\n';
  }
  return escaped;
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::string begin(const std::string& name, const std::string& help) {
  std::string summary = help;
  while (summary.ends_with('.')) summary.pop_back();
  return ".TH " + roff(name) +
         " 1 \"\" \"orbweave " ORBWEAVE_VERSION "\" \"User Commands\"\n.nh\n.ad l\n.SH NAME\n" +
         roff(name) + " \\- " + roff(summary) + "\n";
}

std::string option_text(const OptionFacts& option) {
  std::string names;
  for (const std::string& name : option.names)
    names += (names.empty() ? "" : ", ") + (option.is_argument ? italic(name) : bold(name));
  if (!option.value.empty() && !option.is_argument) names += " " + italic(option.value);
  return ".TP\n" + names + "\n" + roff(option.help + (option.is_required ? " (required)" : "")) +
         "\n";
}

std::string options_text(const std::vector<OptionFacts>& options, bool are_arguments,
                         const char* heading) {
  std::string text;
  for (const OptionFacts& option : options)
    if (option.is_argument == are_arguments) text += option_text(option);
  return text.empty() ? "" : std::string(".SH ") + heading + "\n" + text;
}

/// The lines of help's end, as they are.
std::string example_text(const std::string& example) {
  if (example.empty()) return "";
  return ".SH NOTES AND EXAMPLES\n.nf\n" + roff(example) + (example.ends_with('\n') ? "" : "\n") +
         ".fi\n";
}

std::string statuses_text() {
  std::string text = ".SH EXIT STATUS\n";
  for (const ExitStatusFacts& status : kExitStatuses)
    text += ".TP\n" + bold(std::to_string(static_cast<int>(status.status))) + "\n" +
            roff(status.meaning) + "\n";
  return text;
}

std::string references(const std::vector<std::string>& names) {
  std::string text = ".SH SEE ALSO\n";
  for (std::size_t i = 0; i < names.size(); ++i)
    text += ".BR " + roff(names[i]) + (i + 1 < names.size() ? " (1),\n" : " (1)\n");
  return text;
}

std::string program_page(const ProgramFacts& program) {
  std::string text = begin(program.name, program.help) + ".SH SYNOPSIS\n" + bold(program.name) +
                     " " + italic("COMMAND") + " [" + italic("OPTION") + "...]\n.SH COMMANDS\n";
  std::vector<std::string> pages;
  for (const CommandFacts& command : program.commands) {
    text += ".TP\n" + bold(command.name) + "\n" + roff(command.help) + "\n";
    pages.push_back(program.name + "-" + command.name);
  }
  pages.emplace_back(kTeamProgram);
  return text + options_text(program.options, false, "OPTIONS") + example_text(program.example) +
         statuses_text() + references(pages);
}

/// Of the program for several processes: its commands have pages of their own.
std::string team_page(const ProgramFacts& program) {
  std::string text = begin(kTeamProgram, kTeamHelp) + ".SH SYNOPSIS\n" + bold("mpirun") + " " +
                     bold("-n") + " " + italic("PROCESSES") + " " + bold(kTeamProgram) + " " +
                     italic("COMMAND") + " [" + italic("OPTION") + "...]\n.SH COMMANDS\n";
  std::vector<std::string> pages = {program.name};
  for (const CommandFacts& command : program.commands) {
    if (std::ranges::find(kTeamCommands, command.name) == kTeamCommands.end()) continue;
    text += ".TP\n" + bold(command.name) + "\n" + roff(command.help) + "\n";
    pages.push_back(program.name + "-" + command.name);
  }
  pages.emplace_back("mpirun");
  return text + example_text(kTeamExample) + statuses_text() + references(pages);
}

std::string command_page(const ProgramFacts& program, const CommandFacts& command) {
  std::string synopsis = bold(program.name + " " + command.name);
  for (const OptionFacts& option : command.options)
    if (option.is_argument) synopsis += " " + italic(option.names.front());
  synopsis += " [" + italic("OPTION") + "...]";
  return begin(program.name + "-" + command.name, command.help) + ".SH SYNOPSIS\n" + synopsis +
         "\n" + options_text(command.options, true, "ARGUMENTS") +
         options_text(command.options, false, "OPTIONS") + example_text(command.example) +
         statuses_text() + references({program.name});
}

}  // namespace

std::vector<std::string> manual_page_names(const ProgramFacts& program) {
  std::vector<std::string> names = {program.name};
  for (const CommandFacts& command : program.commands)
    names.push_back(program.name + "-" + command.name);
  names.emplace_back(kTeamProgram);
  return names;
}

std::string manual_page(const ProgramFacts& program, const std::string& name) {
  if (name == program.name) return program_page(program);
  if (name == kTeamProgram) return team_page(program);
  for (const CommandFacts& command : program.commands)
    if (name == program.name + "-" + command.name) return command_page(program, command);
  throw_usage(
      "no manual page of this name",
      {.found = "\"" + name + "\"", .expected = "one of " + joined(manual_page_names(program))});
}

}  // namespace orbweave
