#include "engine/pipeline/run_steps.h"

#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/text/json_dump.h"

namespace orbweave {
namespace {

class RecordedProgress final : public Progress {
 public:
  RecordedProgress(std::unique_ptr<Progress> shown, const std::filesystem::path& file)
      : shown_(std::move(shown)), steps_(file, std::ios::app) {}

  void begin_stage(const std::string& name, std::uint64_t total, const std::string& unit) override {
    steps_ << json_dump({{"step", name}, {"total", total}, {"unit", unit}}) + "\n" << std::flush;
    shown_->begin_stage(name, total, unit);
  }
  void advance(std::uint64_t amount) override { shown_->advance(amount); }
  void add_points(std::uint64_t points) override { shown_->add_points(points); }
  void end_stage() override { shown_->end_stage(); }
  void note(const std::string& line) override { shown_->note(line); }
  void warn(const std::string& line) override { shown_->warn(line); }

 private:
  std::unique_ptr<Progress> shown_;
  std::ofstream steps_;
};

std::optional<RunStep> step_from(const std::string& line) {
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("step") || !json["step"].is_string()) return std::nullopt;
  RunStep step{json["step"].get<std::string>(), 0};
  if (json.contains("total") && json["total"].is_number_unsigned())
    step.total = json["total"].get<std::uint64_t>();
  return step;
}

}  // namespace

std::unique_ptr<Progress> make_recorded_progress(std::unique_ptr<Progress> shown,
                                                 const std::filesystem::path& file) {
  return std::make_unique<RecordedProgress>(std::move(shown), file);
}

std::optional<RunStep> last_step(const std::filesystem::path& file) {
  std::optional<RunStep> last;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);)
    if (std::optional<RunStep> step = step_from(line)) last = std::move(step);
  return last;
}

}  // namespace orbweave
