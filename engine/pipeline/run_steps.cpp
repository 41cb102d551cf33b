#include "engine/pipeline/run_steps.h"

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "io/text/json_dump.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

class RecordedProgress final : public Progress {
 public:
  RecordedProgress(std::unique_ptr<Progress> shown, const std::filesystem::path& file)
      : shown_(std::move(shown)), steps_(file, std::ios::app) {
    write({{"run", "begins"}});
  }

  void expect(std::span<const ExpectedStage> stages) override {
    Json expected = Json::array();
    for (const ExpectedStage& stage : stages) expected.push_back({stage.name, stage.seconds});
    write({{"expected", std::move(expected)}});
    shown_->expect(stages);
  }
  void begin_stage(const std::string& name, std::uint64_t total, const std::string& unit) override {
    write({{"step", name}, {"total", total}, {"unit", unit}});
    shown_->begin_stage(name, total, unit);
  }
  void advance(std::uint64_t amount) override { shown_->advance(amount); }
  void add_points(std::uint64_t points) override { shown_->add_points(points); }
  void end_stage() override {
    write({{"step", nullptr}});
    shown_->end_stage();
  }
  void note(const std::string& line) override { shown_->note(line); }
  void warn(const std::string& line) override { shown_->warn(line); }

 private:
  void write(Json line) {
    line["at"] = run_clock_seconds();
    steps_ << json_dump(line) + "\n" << std::flush;
  }

  std::unique_ptr<Progress> shown_;
  std::ofstream steps_;
};

std::vector<ExpectedStage> expected_from(const Json& json) {
  std::vector<ExpectedStage> stages;
  for (const Json& stage : json)
    if (stage.is_array() && stage.size() == 2 && stage[0].is_string() && stage[1].is_number())
      stages.push_back({stage[0].get<std::string>(), stage[1].get<double>()});
  return stages;
}

void take_line(const Json& json, RunSteps& steps) {
  if (!json.is_object()) return;
  const auto at = json.find("at");
  const double now = at != json.end() && at->is_number() ? at->get<double>() : 0.0;
  if (json.contains("run")) steps.pace = JobPace(now);
  if (const auto expected = json.find("expected"); expected != json.end())
    steps.pace.expect(expected_from(*expected));
  const auto step = json.find("step");
  if (step == json.end()) return;
  if (!step->is_string()) return steps.pace.end_stage(now);
  const auto total = json.find("total");
  steps.last = {step->get<std::string>(), 0};
  if (total != json.end() && total->is_number_unsigned())
    steps.last.total = total->get<std::uint64_t>();
  steps.pace.begin_stage(steps.last.name, now);
}

}  // namespace

double run_clock_seconds() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::unique_ptr<Progress> make_recorded_progress(std::unique_ptr<Progress> shown,
                                                 const std::filesystem::path& file) {
  return std::make_unique<RecordedProgress>(std::move(shown), file);
}

RunSteps stored_steps(const std::filesystem::path& file) {
  RunSteps steps;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    take_line(Json::parse(line, nullptr, false), steps);
  return steps;
}

}  // namespace orbweave
