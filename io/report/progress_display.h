// The progress display that writes to a stream; make_progress makes one for standard error.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <ostream>
#include <string>
#include <thread>

#include "io/report/job_pace.h"
#include "io/report/progress.h"

namespace orbweave {

struct ProgressDisplayOptions {
  bool moving_line = false;     ///< one line that is drawn over and over, else plain lines
  bool colour = false;          ///< warnings in colour
  int columns = 0;              ///< width of the moving line; 0: asked from the terminal each time
  double redraw_seconds = 0.1;  ///< shortest time between two drawings of the moving line
  /// The moving line is drawn at least that often, whether there is progress or not; 0: when there
  /// is progress alone.
  double still_seconds = 0.0;
  double silent_seconds = 10.0;  ///< a plain line at least that often where the total is unknown
  double tenth_seconds = 0.0;    ///< shortest time between two plain lines of a stage
  /// Seconds from some fixed moment; empty: a steady clock. For tests.
  std::function<double()> clock;
};

/// Thread-safe. advance and add_points cost a few atomic operations unless something is printed.
class ProgressDisplay : public Progress {
 public:
  /// `out` must outlive the display.
  ProgressDisplay(std::ostream& out, ProgressDisplayOptions options);
  ~ProgressDisplay() override;  ///< leaves no moving line behind

  void expect(std::span<const ExpectedStage> stages) override;
  void begin_stage(const std::string& name, std::uint64_t total, const std::string& unit) override;
  void advance(std::uint64_t amount) override;
  void add_points(std::uint64_t points) override;
  void end_stage() override;
  void note(const std::string& line) override;
  void warn(const std::string& line) override;

 private:
  double now() const;
  double elapsed() const { return now() - begin_seconds_; }
  std::string amount_text() const;
  std::string rate_text() const;
  std::string left_text() const;
  std::string job_text() const;
  std::string moving_text() const;
  std::string clock_text() const;
  bool is_due();
  void draw_now_and_then();
  void show_progress();
  void draw();
  void clear();
  void print(const std::string& line);
  void print_tenth();
  void finish();

  std::ostream& out_;
  const ProgressDisplayOptions options_;
  std::mutex mutex_;  ///< of everything but the atomic members
  const double start_seconds_;
  JobPace pace_;
  std::string name_;  ///< empty between stages
  std::string unit_;
  double begin_seconds_ = 0.0;
  double line_seconds_ = 0.0;  ///< when the last plain line of the stage was printed
  bool line_is_drawn_ = false;
  std::atomic<std::uint64_t> total_{0};
  std::atomic<std::uint64_t> done_{0};
  std::atomic<std::uint64_t> points_{0};
  std::atomic<double> next_seconds_{0.0};        ///< nothing is printed earlier than that
  std::atomic<std::uint64_t> next_done_{~0ull};  ///< plain lines: the next tenth
  bool is_ending_ = false;
  std::condition_variable ending_;
  std::thread ticker_;  ///< draws the moving line while nothing else does
};

}  // namespace orbweave
