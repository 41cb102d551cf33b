// Numbers with what they count, exact, for messages.
#pragma once

#include <cstdint>
#include <string>

namespace orbweave {

/// "1 point", "3000 points".
inline std::string counted_noun(std::uint64_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

inline std::string counted_points(std::uint64_t count) {
  return counted_noun(count, "point", "points");
}

}  // namespace orbweave
