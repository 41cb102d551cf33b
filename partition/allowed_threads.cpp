#include "partition/allowed_threads.h"

#include <tbb/global_control.h>

#include <algorithm>

namespace orbweave {

int allowed_threads(int threads) {
  const std::size_t allowed =
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return std::min(threads, static_cast<int>(allowed));
}

}  // namespace orbweave
