#include "engine/holes/rbf/block_sizes.h"

#include <Eigen/Core>
#include <mutex>

namespace orbweave {

void fix_block_sizes() {
  static std::once_flag once;
  std::call_once(once, [] { Eigen::setCpuCacheSizes(32 << 10, 256 << 10, 2 << 20); });
}

}  // namespace orbweave
