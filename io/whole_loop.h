// A loop by several threads that is done whole.
#pragma once

#include <cstddef>
#include <functional>

namespace orbweave {

/// Calls body(0) to body(count - 1) on the threads of the calling thread's TBB arena. A loop of TBB
/// inside another one ends early, without a word, where another task of that one has failed: what
/// it would have made is not there, and could be stored. This one makes all of its calls, and
/// throws what one of them throws. A thread that waits here begins no other work: its caller may
/// hold a lock, or memory that is planned for the caller alone.
void for_each_whole(std::size_t count, const std::function<void(std::size_t)>& body);

}  // namespace orbweave
