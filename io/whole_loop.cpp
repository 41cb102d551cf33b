#include "io/whole_loop.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include "io/error.h"

namespace orbweave {

void for_each_whole(std::size_t count, const std::function<void(std::size_t)>& body) {
  tbb::this_task_arena::isolate([&] {
    tbb::task_group_context own(tbb::task_group_context::isolated);
    tbb::parallel_for(std::size_t{0}, count, body, own);
  });
}

void check_loops_are_whole() {
  if (tbb::is_current_task_group_canceling())
    throw Error(ErrorKind::kInterrupted, "interrupted; another part of the work has failed");
}

}  // namespace orbweave
