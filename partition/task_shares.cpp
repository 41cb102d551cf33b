#include "partition/task_shares.h"

#include <algorithm>

namespace orbweave {
namespace {

/// A block is one of so many shares of a process in what is left: one that is half as fast as the
/// others ends its first block when all are done.
constexpr std::uint64_t kShares = 2;
/// Number of times that the counter serves all processes while one does what it takes by a call.
constexpr double kRounds = 2.0;

}  // namespace

TaskShares::TaskShares(std::span<const std::uint64_t> lengths, int processes, int threads)
    : processes_(static_cast<std::size_t>(std::max(processes, 1))), ends_{0}, begins_{0} {
  for (const std::uint64_t length : lengths)
    ends_.push_back(ends_.back() + std::max<std::uint64_t>(length, 1));
  const auto at_once = static_cast<std::size_t>(std::max(threads, 1));
  const std::size_t least = std::min(at_once, (tasks() + processes_ - 1) / processes_);
  for (std::size_t rank = 0; rank < processes_; ++rank) {
    std::size_t end = begins_.back();
    while (end < tasks() && ends_[end + 1] * kShares * processes_ <= (rank + 1) * ends_.back())
      ++end;
    begins_.push_back(std::min(std::max(end, begins_.back() + least), tasks()));
  }
}

TaskRange TaskShares::by_number(int rank) const {
  const auto row = static_cast<std::size_t>(rank);
  return {begins_[row], begins_[row + 1]};
}

std::size_t TaskShares::of_call(std::size_t first, double wanted_length,
                                std::uint64_t latest_length) const {
  if (first >= tasks()) return 1;
  const auto left = static_cast<double>(ends_.back() - ends_[first]);
  const auto processes = static_cast<double>(processes_);
  const double share =
      std::max(0.0, left - (processes - 1.0) * static_cast<double>(latest_length)) /
      (static_cast<double>(kShares) * processes);
  const double target = std::max(share, std::min(wanted_length, left / processes));
  const auto past = std::upper_bound(ends_.begin() + static_cast<std::ptrdiff_t>(first),
                                     ends_.end(), target, [&](double most, std::uint64_t end) {
                                       return most < static_cast<double>(end - ends_[first]);
                                     });
  const auto end = static_cast<std::size_t>(past - ends_.begin()) - 1;
  return std::max<std::size_t>(end - first, 1);
}

double length_worth_a_call(std::uint64_t length, double seconds, int processes,
                           double call_seconds) {
  if (!(seconds > 0.0)) return 0.0;
  return static_cast<double>(length) * kRounds * processes * call_seconds / seconds;
}

}  // namespace orbweave
