#include "engine/cli/reference_page.h"

#include <span>
#include <string_view>

#include "engine/cli/exit_status.h"
#include "io/job/job_reference.h"
#include "io/report/report_fields.h"

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

std::string field_rows(std::span<const ReportField> fields) {
  std::string rows = "| field | meaning |\n|---|---|\n";
  for (const ReportField& field : fields)
    rows += "| `" + std::string(field.name) + "` | " + std::string(field.meaning) + " |\n";
  return rows + "\n";
}

std::string fields_text() {
  return "# Report\n\nThe fields of the JSON that `output.report` names. What a list holds stands "
         "under `[]`.\n\n" +
         field_rows(run_report_fields()) +
         "The report of `orbweave fill` has `version`, `command`, `options`, `origin`, `mesh`, "
         "`pieces_removed`, `triangles_removed`, `holes`, `peak_memory_bytes` and `machine` as "
         "above, and these:\n\n" +
         field_rows(fill_report_fields());
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
