#include "io/report/logged_progress.h"

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <string>

#include "io/report/report.h"
#include "io/shown_text.h"

namespace orbweave {
namespace {

class LoggedProgress final : public Progress {
 public:
  LoggedProgress(Progress& shown, const std::filesystem::path& file) : shown_(shown) {
    if (file.empty()) return;
    try {
      auto sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(file.string(), false);
      log_ = std::make_unique<spdlog::logger>("orbweave", std::move(sink));
      log_->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
      log_->flush_on(spdlog::level::info);
      log_->set_error_handler([](const std::string&) {});
    } catch (const spdlog::spdlog_ex&) {
      log_.reset();
    }
  }

  void expect(std::span<const ExpectedStage> stages) override { shown_.expect(stages); }
  void begin_stage(const std::string& name, std::uint64_t total, const std::string& unit) override {
    stage_ = name;
    points_ = 0;
    line(spdlog::level::info,
         name + ": begins" + (total > 0 ? ", " + std::to_string(total) + " " + unit : ""));
    shown_.begin_stage(name, total, unit);
  }
  void advance(std::uint64_t amount) override { shown_.advance(amount); }
  void add_points(std::uint64_t points) override {
    points_ += points;
    shown_.add_points(points);
  }
  void end_stage() override {
    line(spdlog::level::info, stage_ + ": ends, " + std::to_string(points_) + " points, " +
                                  std::to_string(current_memory_bytes() >> 20) + " MiB");
    shown_.end_stage();
  }
  void note(const std::string& text) override {
    line(spdlog::level::info, text);
    shown_.note(text);
  }
  void warn(const std::string& text) override {
    line(spdlog::level::warn, text);
    shown_.warn(text);
  }

 private:
  void line(spdlog::level::level_enum level, const std::string& text) {
    if (log_) log_->log(level, "{}", orbweave::shown(text));
  }

  Progress& shown_;
  std::unique_ptr<spdlog::logger> log_;
  std::string stage_;  // stages begin and end on one thread
  std::atomic<std::uint64_t> points_{0};
};

}  // namespace

std::unique_ptr<Progress> make_logged_progress(Progress& shown, const std::filesystem::path& file) {
  return std::make_unique<LoggedProgress>(shown, file);
}

}  // namespace orbweave
