// The name of the attribute `intensity` in PLY files that have colours as well.
#pragma once

namespace orbweave {

inline constexpr const char* kIntensity = "intensity";
inline constexpr const char* kScalarIntensity = "scalar_intensity";

}  // namespace orbweave
