#include "engine/cli/reference_page.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "engine/cli/exit_status.h"
#include "io/job/job_reference.h"
#include "io/report/report.h"

namespace orbweave {
namespace {

/// A cell of a table.
std::string cell(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (std::string_view("\\`*_{}[]<>#|").find(c) != std::string_view::npos) escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

std::string option_row(const OptionFacts& option) {
  std::string names;
  for (const std::string& name : option.names) names += (names.empty() ? "`" : ", `") + name + "`";
  return "| " + names + " | " + cell(option.value) + " | " + cell(option.help) +
         (option.is_required ? " (required)" : "") + " |\n";
}

std::string command_text(const CommandFacts& command) {
  std::string text = "### `orbweave " + command.name + "`\n\n" + cell(command.help) + ".\n\n" +
                     "| option | value | what it does |\n|---|---|---|\n";
  for (const OptionFacts& option : command.options) text += option_row(option);
  return text + "\n```text\n" + command.example + (command.example.ends_with('\n') ? "" : "\n") +
         "```\n\n";
}

std::string statuses_text() {
  std::string text = "# Exit statuses\n\n| status | meaning |\n|---|---|\n";
  for (const ExitStatusFacts& status : kExitStatuses)
    text +=
        "| " + std::to_string(static_cast<int>(status.status)) + " | " + status.meaning + " |\n";
  return text + "\n";
}

std::string kind_of(const nlohmann::ordered_json& value) {
  if (value.is_string()) return "text";
  if (value.is_boolean()) return "true or false";
  if (value.is_number()) return "number";
  if (value.is_array()) return "list";
  return value.is_object() ? "object" : "a value, or null where it is not known";
}

/// A row for each field, those of what a list holds under "[]". Options have the names of their
/// keys.
std::string field_rows(const nlohmann::ordered_json& object, const std::string& prefix) {
  std::string rows;
  for (const auto& [key, value] : object.items()) {
    const std::string name = prefix + key;
    rows += "| `" + name + "` | " + kind_of(value) + " |\n";
    if (value.is_object() && name != "options") rows += field_rows(value, name + ".");
    if (value.is_array() && !value.empty() && value.front().is_object())
      rows += field_rows(value.front(), name + "[].");
  }
  return rows;
}

/// Of a report that has one of everything.
std::string fields_text() {
  RunReport report;
  report.holes.resize(1);
  report.holes.front().filled = true;
  report.stages.resize(1);
  return "# Report\n\nThe fields of the JSON that `output.report` names. `options` has the "
         "resolved "
         "keys of the job.\n\n| field | kind |\n|---|---|\n" +
         field_rows(nlohmann::ordered_json::parse(report_json(report)), "") + "\n";
}

}  // namespace

std::string reference_page(const ProgramFacts& program) {
  std::string text =
      "# Reference\n\nMade by `orbweave config --reference` of version " ORBWEAVE_VERSION
      ", from the tables that the program itself reads.\n\n# Keys of job files\n\n" +
      job_key_reference() + "# Commands\n\n";
  for (const CommandFacts& command : program.commands) text += command_text(command);
  return text + fields_text() + statuses_text();
}

}  // namespace orbweave
