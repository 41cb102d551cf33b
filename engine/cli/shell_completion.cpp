#include "engine/cli/shell_completion.h"

#include <string_view>

#include "io/error.h"

namespace orbweave {
namespace {

std::string spaced(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

/// In single quotes, for any of the shells.
std::string in_quotes(std::string_view text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::vector<std::string> names_of(const std::vector<OptionFacts>& options) {
  std::vector<std::string> names;
  for (const OptionFacts& option : options)
    if (!option.is_argument) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

/// The choices of an argument, such as the shapes of `generate`.
std::vector<std::string> choices_of_arguments(const std::vector<OptionFacts>& options) {
  std::vector<std::string> choices;
  for (const OptionFacts& option : options)
    if (option.is_argument)
      choices.insert(choices.end(), option.choices.begin(), option.choices.end());
  return choices;
}

std::vector<std::string> command_names(const ProgramFacts& program) {
  std::vector<std::string> names;
  for (const CommandFacts& command : program.commands) names.push_back(command.name);
  return names;
}

std::string joined_by_bar(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : "|") + word;
  return text;
}

/// The cases of a command: values of options, then options, then files.
std::string bash_command(const CommandFacts& command) {
  std::string values;
  for (const OptionFacts& option : command.options) {
    if (option.is_argument || option.value.empty()) continue;
    const std::string reply =
        option.choices.empty()
            ? ""
            : "COMPREPLY=($(compgen -W " + in_quotes(spaced(option.choices)) + " -- \"$word\")); ";
    values += "        " + joined_by_bar(option.names) + ") " + reply + "return ;;\n";
  }
  return "    " + command.name + ")\n      case $before in\n" + values +
         "      esac\n      options=" + in_quotes(spaced(names_of(command.options))) +
         "\n      choices=" + in_quotes(spaced(choices_of_arguments(command.options))) + " ;;\n";
}

/// Files are left to bash (-o default): it knows names with blanks, quotes and "~".
std::string bash_completion(const ProgramFacts& program) {
  std::string cases;
  for (const CommandFacts& command : program.commands) cases += bash_command(command);
  return "# Completion of " + program.name + " in bash.\n_" + program.name +
         "() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options "
         "choices\n"
         "  COMPREPLY=()\n"
         "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
         "    COMPREPLY=($(compgen -W " +
         in_quotes(spaced(command_names(program)) + " " + spaced(names_of(program.options))) +
         " -- \"$word\"))\n    return\n  fi\n  case ${COMP_WORDS[1]} in\n" + cases +
         "    *) return ;;\n  esac\n"
         "  case $word in\n"
         "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
         "    *) COMPREPLY=($(compgen -W \"$choices\" -- \"$word\")) ;;\n"
         "  esac\n}\ncomplete -o default -F _" +
         program.name + " " + program.name + "\n";
}

/// Text inside of the brackets of a specification of _arguments.
std::string zsh_text(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

std::string zsh_value(const OptionFacts& option) {
  if (option.value.empty()) return "";
  return ":value:" +
         (option.choices.empty() ? std::string("_files") : "(" + spaced(option.choices) + ")");
}

std::string zsh_command(const CommandFacts& command) {
  std::string specs;
  for (const OptionFacts& option : command.options)
    for (const std::string& name : option.names)
      if (!option.is_argument)
        specs += " \\\n        " +
                 in_quotes("*" + name + "[" + zsh_text(option.help) + "]" + zsh_value(option));
  const std::vector<std::string> choices = choices_of_arguments(command.options);
  const std::string words = choices.empty() ? "_files" : "(" + spaced(choices) + ")";
  return "    " + command.name + ")\n      _arguments" + specs + " \\\n        " +
         in_quotes("*:argument:" + words) + " ;;\n";
}

std::string zsh_completion(const ProgramFacts& program) {
  std::string names, cases;
  for (const CommandFacts& command : program.commands) {
    names += "    " + in_quotes(command.name + ":" + zsh_text(command.help)) + "\n";
    cases += zsh_command(command);
  }
  return "#compdef " + program.name + "\n# Completion of " + program.name + " in zsh.\n_" +
         program.name + "() {\n  local -a commands\n  commands=(\n" + names +
         "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
         "  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n" +
         cases + "  esac\n}\n_" + program.name + " \"$@\"\n";
}

std::string fish_option(const std::string& program, const std::string& condition,
                        const OptionFacts& option) {
  std::string line = "complete -c " + program + " -n " + in_quotes(condition);
  for (const std::string& name : option.names)
    line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
  if (!option.value.empty()) line += " -r";
  if (!option.choices.empty()) line += " -f -a " + in_quotes(spaced(option.choices));
  return line + " -d " + in_quotes(option.help) + "\n";
}

std::string fish_completion(const ProgramFacts& program) {
  std::string text = "# Completion of " + program.name + " in fish.\n";
  for (const CommandFacts& command : program.commands)
    text += "complete -c " + program.name + " -n __fish_use_subcommand -f -a " + command.name +
            " -d " + in_quotes(command.help) + "\n";
  for (const OptionFacts& option : program.options)
    text += fish_option(program.name, "__fish_use_subcommand", option);
  for (const CommandFacts& command : program.commands) {
    const std::string condition = "__fish_seen_subcommand_from " + command.name;
    for (const OptionFacts& option : command.options)
      if (!option.is_argument) text += fish_option(program.name, condition, option);
    if (const auto choices = choices_of_arguments(command.options); !choices.empty())
      text += "complete -c " + program.name + " -n " + in_quotes(condition) + " -a " +
              in_quotes(spaced(choices)) + "\n";
  }
  return text;
}

}  // namespace

std::string shell_completion(const ProgramFacts& program, const std::string& shell) {
  if (shell == "bash") return bash_completion(program);
  if (shell == "zsh") return zsh_completion(program);
  if (shell == "fish") return fish_completion(program);
  throw_usage("no completion for this shell",
              {.found = "\"" + shell + "\"", .expected = "bash, zsh or fish"});
}

}  // namespace orbweave
