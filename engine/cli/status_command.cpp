// orbweave status: how far the run got that uses or used a work directory.
#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/cli/commands.h"
#include "engine/cli/json_text.h"
#include "engine/cli/output.h"
#include "engine/pipeline/pipeline.h"
#include "engine/pipeline/stage/stages.h"
#include "io/error.h"
#include "io/text/quantity.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

struct StatusOptions {
  std::string work_dir;
  bool json = false;
  bool stages = false;  ///< the table of stages, of no work directory
};

const char* name_of(StageWork work) {
  switch (work) {
    case StageWork::kShared:
      return "shared";
    case StageWork::kLeader:
      return "leader";
    case StageWork::kRedundant:
      break;
  }
  return "redundant";
}

nlohmann::ordered_json scaling_json(const StageScaling& scaling) {
  return {{"work", name_of(scaling.work)},
          {"threads", scaling.threads},
          {"grows", scaling.constant ? "constant" : "points"},
          {"fixed", scaling.fixed_seconds},
          {"computes", scaling.computes},
          {"leader", scaling.leader_share},
          {"merge", scaling.merge_seconds},
          {"team_io", scaling.team_io}};
}

/// A line per stage.
std::string stages_json() {
  std::string lines;
  for (const StageInfo& info : kStages) {
    const nlohmann::ordered_json line = {{"name", info.name},
                                         {"directory", info.directory},
                                         {"results", info.results},
                                         {"repeats", info.repeats},
                                         {"dropped_by_fresh", info.dropped_by_fresh},
                                         {"scaling", scaling_json(info.scaling)}};
    lines += (lines.empty() ? "  " : ",\n  ") + line.dump();
  }
  return "{\"stages\": [\n" + lines + "\n]}\n";
}

std::string stages_text() {
  std::vector<std::vector<std::string>> rows = {
      {"stage", "results", "directory", "work", "dropped by --fresh"}};
  for (const StageInfo& info : kStages)
    rows.push_back({info.name, info.results, info.directory, name_of(info.scaling.work),
                    info.dropped_by_fresh ? "yes" : "no"});
  return table(rows);
}

std::string status_json(const WorkStatus& status) {
  nlohmann::ordered_json stages = nlohmann::ordered_json::array();
  for (const StageStatus& stage : status.stages)
    stages.push_back({{"name", stage.name},
                      {"chunks_done", stage.chunks_done},
                      {"chunks_in_flight", stage.chunks_in_flight},
                      {"chunks_total", stage.chunks_total},
                      {"done", stage.done}});
  nlohmann::ordered_json document = {{"running", status.running}};
  if (status.process_id != 0) document["process_id"] = status.process_id;
  if (!status.members.empty()) document["members"] = status.members;
  document["step"] = status.step;
  document["ended"] = status.ended;
  if (status.pace) {
    document["seconds"] = status.pace->elapsed;
    document["share"] = status.pace->share();
    document["seconds_left"] = status.pace->seconds_left;
  }
  document["last_touched"] = status.last_touched;
  document["stages"] = stages;
  return json_text(document);
}

std::string state_of(const StageStatus& stage) {
  if (stage.done) return "done";
  return stage.chunks_done + stage.chunks_in_flight > 0 ? "begun" : "not begun";
}

/// Chunks that are neither done nor in flight.
std::string left_of(const StageStatus& stage) {
  const std::uint64_t begun = stage.chunks_done + stage.chunks_in_flight;
  if (stage.chunks_total >= begun && stage.chunks_total > 0)
    return format_count(stage.chunks_total - begun);
  return stage.done ? "0" : "not known";
}

std::string use_of(const WorkStatus& status) {
  const std::string process = "process " + std::to_string(status.process_id);
  if (status.running) return "in use by " + process;
  return status.process_id == 0 ? "not in use" : "not in use; last by " + process;
}

std::string status_text(const WorkStatus& status) {
  std::vector<std::vector<std::string>> rows = {
      {"stage", "state", "chunks done", "in flight", "left"}};
  for (const StageStatus& stage : status.stages) {
    rows.push_back({stage.name, state_of(stage), format_count(stage.chunks_done),
                    format_count(stage.chunks_in_flight), left_of(stage)});
  }
  Facts facts = {{"work directory", use_of(status)}};
  if (!status.members.empty())
    facts.emplace_back(status.running ? "with" : "still at work", joined(status.members));
  if (status.ended)
    facts.emplace_back("job", "ended; all outputs are written");
  else if (!status.running)
    facts.emplace_back("job", "stopped before its end; the same command resumes");
  if (!status.ended && !status.step.empty())
    facts.emplace_back(status.running ? "at" : "was at", status.step);
  if (status.pace)
    facts.emplace_back("done", std::to_string(status.pace->percent()) + " % after " +
                                   format_duration(status.pace->elapsed) + "; about " +
                                   format_duration(status.pace->seconds_left) + " left");
  facts.emplace_back("last touched", status.last_touched);
  return facts_table(facts) + "\n" + table(rows);
}

void show_stages(bool json) { std::cout << (json ? stages_json() : stages_text()); }

void show_status(const StatusOptions& options) {
  if (options.stages) return show_stages(options.json);
  if (options.work_dir.empty())
    throw_usage("names no work directory", {.expected = "orbweave status WORK_DIR"});
  const WorkStatus status = work_status(options.work_dir);
  std::cout << (options.json ? status_json(status) : status_text(status));
}

}  // namespace

void add_status_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<StatusOptions>();
  CLI::App* command = program.add_subcommand(
      "status", "Show which stages and chunks of a run are done, from its work directory");
  command->add_option("WORK_DIR", options->work_dir, "The run's work directory")->type_name("");
  command->add_flag("--json", options->json, "Print JSON");
  command->add_flag("--stages", options->stages,
                    "Show the table of all stages instead, of no work directory");
  command->footer("Example:\n  orbweave status mesh.work\n");
  command->callback([options, context] { context.then([options] { show_status(*options); }); });
}

}  // namespace orbweave
