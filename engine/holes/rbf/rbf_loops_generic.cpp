// Radial basis functions for machines without wider vectors, and the choice of the form.
#include "engine/geometry/vector_width.h"
#include "engine/holes/rbf/rbf_loops.inl"

namespace orbweave {

RbfLoops rbf_loops_generic() { return kLoops; }

const RbfLoops& rbf_loops() {
#if defined(ORBWEAVE_X86)
  static const RbfLoops loops =
      widest_supported() != VectorWidth::kScalar ? rbf_loops_avx2() : rbf_loops_generic();
#else
  static const RbfLoops loops = rbf_loops_generic();
#endif
  return loops;
}

}  // namespace orbweave
