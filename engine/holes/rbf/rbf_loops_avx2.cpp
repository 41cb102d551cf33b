// Radial basis functions on four lanes; compiled for AVX2, chosen at run time.
#include "engine/holes/rbf/rbf_loops.inl"

namespace orbweave {

RbfLoops rbf_loops_avx2() { return kLoops; }

}  // namespace orbweave
