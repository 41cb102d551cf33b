// Vector widths that this machine runs.
#pragma once

#include <vector>

#include "engine/geometry/vector_width.h"

namespace orbweave::test {

inline std::vector<VectorWidth> supported_widths() {
  std::vector<VectorWidth> widths;
  for (const VectorWidth w : {VectorWidth::kScalar, VectorWidth::kAvx2, VectorWidth::kAvx512}) {
    if (w <= widest_supported()) widths.push_back(w);
  }
  return widths;
}

}  // namespace orbweave::test
