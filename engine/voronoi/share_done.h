// The progress of long work, as a share.
#pragma once

#include <functional>

namespace orbweave::voronoi {

/// Hears of the share of some work that is done, from 0 to 1, ascending. May be empty.
using ShareDone = std::function<void(double)>;

}  // namespace orbweave::voronoi
