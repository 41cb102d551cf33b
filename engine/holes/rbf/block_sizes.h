// The block sizes of dense products and solves.
#pragma once

namespace orbweave {

/// Call it before any dense product or solve of matrices whose size is known at run time only.
/// Eigen cuts sums at block sizes that it derives from the processor's caches: with the same caches
/// everywhere, results are the same everywhere. Safe for many threads, cheap after the first call.
void fix_block_sizes();

}  // namespace orbweave
