// The vector width that kernels are chosen by at run time. Units compiled for other machines
// include this header: it defines nothing.
#pragma once

namespace orbweave {

enum class VectorWidth { kScalar, kAvx2, kAvx512 };

/// The widest that this machine runs.
VectorWidth widest_supported();

}  // namespace orbweave
