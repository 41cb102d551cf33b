#include "engine/cli/reference_page.h"

#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "engine/cli/exit_status.h"
#include "io/job/job_reference.h"
#include "io/report/report.h"
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

std::string kind_of(const nlohmann::json& value) {
  if (value.is_string()) return "text";
  if (value.is_boolean()) return "true or false";
  if (value.is_number()) return "number";
  if (value.is_array()) return "list";
  return value.is_object() ? "object" : "a value, or null where it is not known";
}

using Kinds = std::map<std::string, std::string, std::less<>>;

/// The kind of each field of a report, of those of what a list holds under "[]".
void add_kinds(const nlohmann::json& object, const std::string& prefix, Kinds& kinds) {
  for (const auto& [key, value] : object.items()) {
    const std::string name = prefix + key;
    kinds[name] = kind_of(value);
    if (value.is_object()) add_kinds(value, name + ".", kinds);
    if (value.is_array() && !value.empty() && value.front().is_object())
      add_kinds(value.front(), name + "[].", kinds);
  }
}

/// By reports that have one of everything.
Kinds kinds_of_fields() {
  FillReport fill;
  fill.before.bounds.extend(Vec3{});
  RunReport run;
  run.holes.resize(1);
  run.holes.front().filled = true;
  run.stages.resize(1);
  run.trusted.resize(1);
  run.voronoi.emplace();
  run.bounds.extend(Vec3{});
  run.mesh.bounds.extend(Vec3{});
  run.normals.contested_places.resize(1);
  run.normals.doubtful.resize(1);
  Kinds kinds;
  add_kinds(nlohmann::json::parse(fill_report_json(fill)), "", kinds);
  add_kinds(nlohmann::json::parse(report_json(run)), "", kinds);
  return kinds;
}

std::string field_rows(std::span<const ReportField> fields, const Kinds& kinds) {
  std::string rows = "| field | kind | meaning |\n|---|---|---|\n";
  for (const ReportField& field : fields) {
    const auto kind = kinds.find(field.name);
    rows += "| `" + std::string(field.name) + "` | " +
            (kind == kinds.end() ? kind_of(nullptr) : kind->second) + " | " +
            std::string(field.meaning) + " |\n";
  }
  return rows + "\n";
}

std::string fields_text() {
  const Kinds kinds = kinds_of_fields();
  return "# Report\n\nThe fields of the JSON that `output.report` names. What a list holds stands "
         "under `[]`.\n\n" +
         field_rows(run_report_fields(), kinds) +
         "The report of `orbweave fill` has `version`, `command`, `options`, `origin`, `mesh`, "
         "`pieces_removed`, `triangles_removed`, `holes`, `peak_memory_bytes` and `machine` as "
         "above, and these:\n\n" +
         field_rows(fill_report_fields(), kinds);
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
