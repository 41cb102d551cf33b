#include "io/report/job_pace.h"

#include <algorithm>

namespace orbweave {
namespace {

/// Rates of stages differ, and a stage that found its results in the work directory says nothing
/// about a machine: the expectation counts as much as that share of the expected time would.
constexpr double kTrustInExpectation = 0.2;
/// A stage is at least as long as the time that it took for what is done, from that share on.
constexpr double kLeastShareForRate = 0.02;
constexpr double kLeastSecondsForRate = 1.0;

double sum_of(std::span<const ExpectedStage> stages) {
  double sum = 0.0;
  for (const ExpectedStage& stage : stages) sum += stage.seconds;
  return sum;
}

}  // namespace

void JobPace::expect(std::span<const ExpectedStage> stages) {
  is_known_ = true;
  pending_.assign(stages.begin(), stages.end());
  const auto last = std::ranges::find(pending_, last_begun_, &ExpectedStage::name);
  if (last != pending_.end()) pending_.erase(pending_.begin(), last + 1);
}

void JobPace::begin_stage(const std::string& name, double now) {
  const auto found = std::ranges::find(pending_, name, &ExpectedStage::name);
  last_begun_ = name;
  is_active_ = true;
  active_begin_ = now;
  active_expected_ = found == pending_.end() ? 0.0 : found->seconds;
  if (found != pending_.end()) pending_.erase(pending_.begin(), found + 1);
}

void JobPace::end_stage(double now) {
  if (is_active_ && active_expected_ > 0.0) {
    ended_seconds_ += now - active_begin_;
    ended_expected_ += active_expected_;
  }
  is_active_ = false;
}

/// How much longer stages take than expected.
double JobPace::scale() const {
  const double trust =
      kTrustInExpectation * (ended_expected_ + active_expected_ + sum_of(pending_));
  if (!(trust > 0.0)) return 1.0;
  return (ended_seconds_ + trust) / (ended_expected_ + trust);
}

double JobPace::left_of_stage(double now, std::uint64_t done, std::uint64_t total) const {
  if (!is_active_) return 0.0;
  const double elapsed = std::max(now - active_begin_, 0.0);
  const double expected = std::max(scale() * active_expected_ - elapsed, 0.0);
  if (total == 0) return expected;
  const double share = std::min(static_cast<double>(done) / static_cast<double>(total), 1.0);
  if (share < kLeastShareForRate || elapsed < kLeastSecondsForRate)
    return std::max(expected, scale() * active_expected_ * (1.0 - share));
  return elapsed * (1.0 - share) / share;
}

JobPace::Estimate JobPace::at(double now, std::uint64_t done, std::uint64_t total) const {
  return {std::max(now - begin_, 0.0),
          scale() * sum_of(pending_) + left_of_stage(now, done, total)};
}

}  // namespace orbweave
