// Numbers as the hexadecimal digits that names, checksums and identities are written in.
#pragma once

#include <cstdint>
#include <string>

namespace orbweave {

/// 16 lower-case digits, the highest first.
inline std::string hex_digits(std::uint64_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text(16, '0');
  for (auto digit = text.rbegin(); value != 0; ++digit, value >>= 4) *digit = kDigits[value & 15];
  return text;
}

}  // namespace orbweave
