// What the allocator keeps of memory that is freed.
#pragma once

#include <cstdint>

namespace orbweave {

/// Lets the allocator of this process keep up to a sixteenth of the budget in bytes for the next
/// allocations of `threads` threads, instead of giving pages back that are asked for again a moment
/// later. Does nothing where the heaps of the threads may take more than an eighth of the budget,
/// and where the allocator is not glibc's. For programs alone: it changes the whole process.
void keep_freed_memory(std::uint64_t budget_bytes, int threads);

}  // namespace orbweave
