// orbweave status: how far the run got that uses or used a work directory.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/cli/commands.h"
#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/pipeline/pipeline.h"
#include "io/quantity.h"

namespace orbweave {
namespace {

struct StatusOptions {
  std::string work_dir;
  bool json = false;
};

std::string status_json(const WorkStatus& status) {
  nlohmann::ordered_json stages = nlohmann::ordered_json::array();
  for (const StageStatus& stage : status.stages)
    stages.push_back({{"name", stage.name},
                      {"chunks_done", stage.chunks_done},
                      {"chunks_total", stage.chunks_total},
                      {"done", stage.done}});
  nlohmann::ordered_json document = {{"running", status.running}};
  if (status.running) document["process_id"] = status.process_id;
  document["last_touched"] = status.last_touched;
  document["stages"] = stages;
  return json_text(document);
}

std::string state_of(const StageStatus& stage) {
  if (stage.done) return "done";
  return stage.chunks_done > 0 ? "begun" : "not begun";
}

std::string status_text(const WorkStatus& status) {
  std::vector<std::vector<std::string>> rows = {{"stage", "state", "chunks done", "chunks left"}};
  for (const StageStatus& stage : status.stages) {
    const bool known = stage.chunks_total >= stage.chunks_done && stage.chunks_total > 0;
    rows.push_back({stage.name, state_of(stage), format_count(stage.chunks_done),
                    known ? format_count(stage.chunks_total - stage.chunks_done) : "?"});
  }
  const std::string run =
      status.running ? "in use by process " + std::to_string(status.process_id) : "not in use";
  return facts_table({{"work directory", run}, {"last touched", status.last_touched}}) + "\n" +
         table(rows);
}

void show_status(const StatusOptions& options) {
  const WorkStatus status = work_status(options.work_dir);
  std::cout << (options.json ? status_json(status) : status_text(status));
}

}  // namespace

void add_status_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<StatusOptions>();
  CLI::App* command = program.add_subcommand(
      "status", "Show which stages and chunks of a run are done, from its work directory");
  command->add_option("WORK_DIR", options->work_dir, "The run's work directory")
      ->type_name("")
      ->required();
  command->add_flag("--json", options->json, "Print JSON");
  command->footer("Example:\n  orbweave status mesh.work\n");
  command->callback([options, context] { context.then([options] { show_status(*options); }); });
}

}  // namespace orbweave
