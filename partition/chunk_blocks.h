// Blocks of consecutive chunks that the processes of a job take from their common counter: large at
// first, so that the counter is asked rarely and neighbours stay together, small at the end, where
// everybody waits for the last. Guided self-scheduling: Polychronopoulos and Kuck,
// Guided Self-Scheduling: A Practical Scheduling Scheme for Parallel Supercomputers, 1987.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace orbweave {

/// First task of every block, and behind them the number of tasks. `lengths`: how long each task
/// takes, compared with the others, the longest first. A block has 1 / (2 processes) of the length
/// that is left, rounded to whole tasks, and at least one task. The first `processes` blocks have
/// at least `threads` tasks each, or an equal share where there are fewer tasks. Equal arguments
/// give equal blocks in every process. O(tasks).
std::vector<std::size_t> cut_blocks(std::span<const std::uint64_t> lengths, int processes,
                                    int threads);

}  // namespace orbweave
