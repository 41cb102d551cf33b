// Runs a small job with one fault of the file system after another
// (tests/faults/faulty_orbweave.cpp).
#pragma once

#include <cstdint>
#include <string>

namespace orbweave::test {

/// Runs a job once for each of the calls first, first + step, ... (from 1) of a kind, with that one
/// call failing, and repeats the command without a fault. Checks that the run with the fault makes
/// the same mesh or ends in a clear error with status 4, and that the repeated command makes the
/// same mesh and leaves nothing else behind. Prints the number of injected faults.
void try_faults(const std::string& kind, const std::string& effect, std::uint64_t first = 1,
                std::uint64_t step = 1);

/// Calls that flush in a job whose new work directory is not flushed for so long, and in the same
/// job where a run that failed has left one.
struct FlushCounts {
  std::uint64_t in_new = 0;
  std::uint64_t in_older = 0;
};
FlushCounts count_flushes(std::uint64_t seconds_unflushed);

}  // namespace orbweave::test
