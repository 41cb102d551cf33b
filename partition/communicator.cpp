#include "partition/communicator.h"

#include "io/system/process_times.h"

namespace orbweave {

std::uint64_t Communicator::fetch_next(std::uint64_t amount) {
  const double begin = steady_seconds();
  const std::uint64_t before = count_up(amount);
  const double seconds = steady_seconds() - begin;
  double least = counter_seconds_;
  while (seconds < least && !counter_seconds_.compare_exchange_weak(least, seconds)) {
  }
  ++counter_calls_;
  return before;
}

}  // namespace orbweave
