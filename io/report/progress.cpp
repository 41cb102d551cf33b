#include "io/report/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <limits>

#include "io/report/progress_display.h"
#include "io/report/report.h"
#include "io/shown_text.h"
#include "io/system/process_times.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kNever = std::numeric_limits<std::uint64_t>::max();
constexpr const char* kClearLine = "\r\033[K";
constexpr const char* kYellow = "\033[1;33m";
constexpr const char* kPlainColour = "\033[0m";
/// Before that a rate says more about the start than about the stage.
constexpr double kLeastSecondsForForecast = 1.0;

int terminal_columns() {
  winsize size{};
  if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

bool variable_is_set(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0';
}

bool terminal_moves() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) == 1 && (terminal == nullptr || std::string(terminal) != "dumb");
}

/// The smallest amount above `done` that is a tenth of the total, or two, ...; the last one is
/// left to the stage's end.
std::uint64_t next_tenth(std::uint64_t done, std::uint64_t total) {
  for (std::uint64_t tenth = 1; tenth < 10; ++tenth) {
    const auto amount = static_cast<std::uint64_t>(
        std::ceil(static_cast<double>(total) * static_cast<double>(tenth) / 10.0));
    if (amount > done) return amount;
  }
  return kNever;
}

/// "1 chunk" of "chunks", "1 batch" of "batches".
std::string counted(std::uint64_t count, const std::string& unit) {
  const std::size_t ending = count != 1 ? 0 : unit.ends_with("ches") ? 2 : 1;
  return format_count(count) + " " + unit.substr(0, unit.size() - ending);
}

class Silence : public Progress {
 public:
  void begin_stage(const std::string&, std::uint64_t, const std::string&) override {}
  void advance(std::uint64_t) override {}
  void add_points(std::uint64_t) override {}
  void end_stage() override {}
  void note(const std::string&) override {}
  void warn(const std::string&) override {}
};

/// What is in doubt is said however little the reader wants to see.
class WarningsOnly final : public Silence {
 public:
  void warn(const std::string& line) override { display_.warn(line); }

 private:
  ProgressDisplay display_{std::cerr, {}};
};

}  // namespace

ProgressDisplay::ProgressDisplay(std::ostream& out, ProgressDisplayOptions options)
    : out_(out), options_(std::move(options)), start_seconds_(now()), pace_(start_seconds_) {
  if (options_.moving_line && options_.still_seconds > 0.0)
    ticker_ = std::thread([this] { draw_now_and_then(); });
}

ProgressDisplay::~ProgressDisplay() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  ending_.notify_all();
  if (ticker_.joinable()) ticker_.join();
  clear();
}

/// A chunk may take a minute: the time goes on meanwhile, as a sign that the job is alive.
void ProgressDisplay::draw_now_and_then() {
  const std::chrono::duration<double> interval(options_.still_seconds);
  std::unique_lock lock(mutex_);
  while (!ending_.wait_for(lock, interval, [this] { return is_ending_; })) {
    // `next_seconds_` is a redraw after the last drawing.
    const double still = now() - (next_seconds_.load() - options_.redraw_seconds);
    if (!name_.empty() && still >= 0.5 * options_.still_seconds) draw();
  }
}

double ProgressDisplay::now() const { return options_.clock ? options_.clock() : steady_seconds(); }

void ProgressDisplay::expect(std::span<const ExpectedStage> stages) {
  const std::lock_guard lock(mutex_);
  pace_.expect(stages);
}

void ProgressDisplay::begin_stage(const std::string& name, std::uint64_t total,
                                  const std::string& unit) {
  const std::lock_guard lock(mutex_);
  finish();
  pace_.begin_stage(name, now());
  name_ = name;
  unit_ = unit;
  total_ = total;
  begin_seconds_ = now();
  done_ = 0;
  points_ = 0;
  line_seconds_ = begin_seconds_;
  // A stage that ends at once shows nothing but its end.
  next_seconds_ = begin_seconds_ + (options_.moving_line ? 0.0 : options_.silent_seconds);
  next_done_ = options_.moving_line ? kNever : next_tenth(0, total);
  if (!options_.moving_line)
    print(name_ + ": begins" + (total > 0 ? ", " + counted(total, unit_) : ""));
}

void ProgressDisplay::advance(std::uint64_t amount) {
  done_.fetch_add(amount, std::memory_order_relaxed);
  show_progress();
}

void ProgressDisplay::add_points(std::uint64_t points) {
  points_.fetch_add(points, std::memory_order_relaxed);
  show_progress();
}

bool ProgressDisplay::is_due() {
  if (options_.moving_line || total_ == 0) return now() >= next_seconds_.load();
  return done_.load(std::memory_order_relaxed) >= next_done_.load(std::memory_order_relaxed);
}

void ProgressDisplay::show_progress() {
  if (!is_due()) return;
  const std::lock_guard lock(mutex_);
  if (name_.empty() || !is_due()) return;
  if (options_.moving_line) {
    draw();
  } else {
    print_tenth();
  }
}

void ProgressDisplay::draw() {
  const int columns = options_.columns > 0 ? options_.columns : terminal_columns();
  // The last column stays free: some terminals wrap as soon as it is filled.
  const std::size_t width = static_cast<std::size_t>(std::max(columns - 1, 1));
  out_ << kClearLine << moving_text().substr(0, width) << std::flush;
  line_is_drawn_ = true;
  next_seconds_ = now() + options_.redraw_seconds;
}

/// Several tenths may pass at once; the line says where the stage stands now.
void ProgressDisplay::print_tenth() {
  const std::uint64_t done = done_.load(), total = total_.load();
  next_seconds_ = now() + options_.silent_seconds;
  next_done_ = next_tenth(done, total);
  if (now() - line_seconds_ < options_.tenth_seconds) return;
  line_seconds_ = now();
  if (total == 0 || done < total) print(moving_text());
}

std::string ProgressDisplay::amount_text() const {
  const std::uint64_t done = done_.load(), total = total_.load();
  if (total == 0) return counted(done, unit_);
  const double share = static_cast<double>(std::min(done, total)) / static_cast<double>(total);
  return format_count(done) + " / " + counted(total, unit_) + " (" +
         std::to_string(static_cast<int>(100.0 * share)) + " %)";
}

std::string ProgressDisplay::rate_text() const {
  const std::uint64_t points = unit_ == "points" ? done_.load() : points_.load();
  const double seconds = elapsed();
  if (points == 0 || !(seconds > 0.0)) return "";
  return ", " + format_rate(static_cast<double>(points) / seconds) + " points/s";
}

/// "job 41 %, 12 s left".
std::string ProgressDisplay::job_text() const {
  const JobPace::Estimate job = pace_.at(now(), done_.load(), total_.load());
  return "job " + std::to_string(job.percent()) + " %, " + format_duration(job.seconds_left) +
         " left";
}

/// Of the stage.
std::string ProgressDisplay::left_text() const {
  const std::uint64_t done = done_.load(), total = total_.load();
  const double seconds = elapsed();
  if (done == 0 || done >= total || seconds < kLeastSecondsForForecast) return "";
  const double left = seconds * static_cast<double>(total - done) / static_cast<double>(done);
  return ", " + format_duration(left) + " left";
}

/// Minutes and seconds since the job began: "2:05".
std::string ProgressDisplay::clock_text() const {
  const auto seconds = static_cast<std::uint64_t>(std::max(now() - start_seconds_, 0.0));
  const std::string rest = std::to_string(seconds % 60);
  return std::to_string(seconds / 60) + (rest.size() < 2 ? ":0" : ":") + rest + "  ";
}

/// The moving line begins with what a narrow terminal must not cut.
std::string ProgressDisplay::moving_text() const {
  std::string text =
      name_ + ": " + amount_text() + rate_text() + ", " + format_bytes(current_memory_bytes());
  // A share of the first moments would be one of start-up, and fall when the work begins.
  const bool tells_job = pace_.is_known() && now() - start_seconds_ >= kLeastSecondsForForecast;
  if (!pace_.is_known()) text += left_text();
  if (!options_.moving_line) return text + (tells_job ? ", " + job_text() : "");
  return clock_text() + (tells_job ? job_text() + "  " : "") + text;
}

void ProgressDisplay::clear() {
  if (line_is_drawn_) out_ << kClearLine << std::flush;
  line_is_drawn_ = false;
}

/// A whole line, above the moving one; in one piece, because others write to the same terminal.
void ProgressDisplay::print(const std::string& line) {
  const bool was_drawn = line_is_drawn_;
  clear();
  out_ << line + "\n" << std::flush;
  if (was_drawn && !name_.empty()) draw();
}

void ProgressDisplay::finish() {
  if (name_.empty()) return;
  // A stage that an error or an interruption ends is not done.
  const char* const end = std::uncaught_exceptions() > 0 ? ": stopped after " : ": done in ";
  const std::string line = name_ + end + format_duration(elapsed()) + ", " +
                           counted(done_.load(), unit_) + rate_text() + ", " +
                           format_bytes(current_memory_bytes());
  name_.clear();
  pace_.end_stage(now());
  next_done_ = kNever;
  clear();
  if (!options_.moving_line) print(line);
}

void ProgressDisplay::end_stage() {
  const std::lock_guard lock(mutex_);
  finish();
}

void ProgressDisplay::note(const std::string& line) {
  const std::lock_guard lock(mutex_);
  print(shown(line));
}

void ProgressDisplay::warn(const std::string& line) {
  const std::lock_guard lock(mutex_);
  const std::string label = "warning: ";
  print("orbweave: " + (options_.colour ? kYellow + label + kPlainColour : label) + shown(line));
}

std::unique_ptr<Progress> make_progress(ProgressStyle style) {
  if (style == ProgressStyle::kSilent) return std::make_unique<Silence>();
  if (style == ProgressStyle::kNone) return std::make_unique<WarningsOnly>();
  const bool terminal = style == ProgressStyle::kAuto && terminal_moves();
  ProgressDisplayOptions options;
  options.moving_line = terminal;
  options.still_seconds = 1.0;
  options.tenth_seconds = 1.0;  // short stages need no tenths in a log
  options.colour = terminal && !variable_is_set("NO_COLOR");
  return std::make_unique<ProgressDisplay>(std::cerr, options);
}

}  // namespace orbweave
