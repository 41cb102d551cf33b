// A loop by several threads that is done whole.
#pragma once

#include <cstddef>
#include <functional>

namespace orbweave {

/// Calls body(0) to body(count - 1) on the threads of the calling thread's TBB arena. All calls are
/// made, unless one of them throws, which is rethrown. (TBB ends a loop early, without a word,
/// where a task of the loop around it has failed. Results with parts missing could be stored then.)
/// A thread that waits here begins no other work: its caller may hold a lock, or memory that is
/// planned for the caller alone.
void for_each_whole(std::size_t count, const std::function<void(std::size_t)>& body);

/// Throws Error (interrupted) where a task around the caller has failed: other loops of the caller
/// may have ended early then, and lists that the loops fill may hold values at random. The failure
/// itself is what the caller of the failed loop gets to see.
void check_loops_are_whole();

}  // namespace orbweave
