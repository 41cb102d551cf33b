// What a person sees while a job runs.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/report/report_facts.h"

namespace orbweave {

/// Receives a job's progress. Thread-safe.
class Progress {
 public:
  virtual ~Progress() = default;
  /// The stages of the job in their order, as far as they are known by now; the present one and
  /// those that ended are passed over. Stages that do not run may be among them.
  virtual void expect(std::span<const ExpectedStage> /*stages*/) {}
  /// A stage begins; total work in `unit`s ("points", "chunks"), 0 when unknown.
  virtual void begin_stage(const std::string& name, std::uint64_t total,
                           const std::string& unit) = 0;
  virtual void advance(std::uint64_t amount) = 0;
  /// Points done in this stage, for the rate.
  virtual void add_points(std::uint64_t points) = 0;
  virtual void end_stage() = 0;
  /// A line for the reader: a decision and why, or a warning.
  virtual void note(const std::string& line) = 0;
  virtual void warn(const std::string& line) = 0;
};

enum class ProgressStyle { kAuto, kPlain, kNone, kSilent };

/// kAuto: one line that moves on a terminal (time since the start, share and time left of the job
/// once they are known, stage, chunks, points/s, memory; drawn every second at least), plain lines
/// (one per stage and per tenth of it, at most one a second) otherwise; colour only on a terminal
/// without NO_COLOR. kNone: warnings alone; kSilent: nothing. Writes to standard error.
std::unique_ptr<Progress> make_progress(ProgressStyle style);

}  // namespace orbweave
