// How far a whole job is, from how long its stages typically take and how long they took so far.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/report/report_facts.h"

namespace orbweave {

/// Share and time left of a job. Times are seconds from any fixed moment.
class JobPace {
 public:
  explicit JobPace(double begin = 0.0) : begin_(begin) {}

  /// The stages of the job in their order; replaces what was expected before. The present one and
  /// those before it are passed over.
  void expect(std::span<const ExpectedStage> stages);
  /// Expected stages before this one do not run.
  void begin_stage(const std::string& name, double now);
  void end_stage(double now);

  /// Whether the stages to come are known.
  bool is_known() const { return is_known_; }

  struct Estimate {
    double elapsed = 0.0;       ///< seconds since the job began
    double seconds_left = 0.0;  ///< of the whole job
    /// Of the job's time, 0 to 1.
    double share() const { return elapsed > 0.0 ? elapsed / (elapsed + seconds_left) : 0.0; }
    /// Never 100: a job that shows it has not ended.
    int percent() const { return std::min(static_cast<int>(100.0 * share()), 99); }
  };
  /// `done` of `total` units of the present stage are done; a total of 0: not known.
  Estimate at(double now, std::uint64_t done, std::uint64_t total) const;

 private:
  double scale() const;
  double left_of_stage(double now, std::uint64_t done, std::uint64_t total) const;

  double begin_;
  bool is_known_ = false;
  std::vector<ExpectedStage> pending_;
  double ended_seconds_ = 0.0;   ///< that expected stages took
  double ended_expected_ = 0.0;  ///< that they were expected to take
  std::string last_begun_;
  bool is_active_ = false;
  double active_begin_ = 0.0;
  double active_expected_ = 0.0;  ///< 0: the stage was not expected
};

}  // namespace orbweave
