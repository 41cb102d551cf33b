// The walk, one point at a time: the form for machines without wider vectors.
#include "engine/ball_pivoting/walk_kernel.inl"

namespace orbweave {

WalkKernel walk_kernel_generic() { return {gather, gather_crowd, walk, suspect, confirm}; }

}  // namespace orbweave
