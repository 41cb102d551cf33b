// How many threads an arena may ask TBB for.
#pragma once

namespace orbweave {

/// As many of `threads` as TBB is allowed to use. More are for the program to allow, by
/// tbb::global_control; TBB complains on standard error where they are asked for.
int allowed_threads(int threads);

}  // namespace orbweave
