// The standard classes of points (ASPRS, LAS Specification 1.4 R15, table 17).
#pragma once

#include <array>
#include <string>

namespace orbweave {

inline constexpr std::size_t kPointClasses = 256;

/// Classes of points that are no surface: low point and high noise.
inline constexpr std::array<int, 2> kNoiseClasses = {7, 18};

/// "low vegetation"; empty where the class has no standard name.
std::string plain_name_of_class(int number);
/// "class 3 (low vegetation)"; "class 40" where the class has no standard name.
std::string name_of_class(int number);
/// Why a point of a class that is not wanted is left out: "class 7 (low point) left out". The keys
/// of DroppedPoints.
std::string text_of_dropped_class(int number);

}  // namespace orbweave
