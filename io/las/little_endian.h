// Values as LAS files hold them: little-endian, at any address.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace orbweave::las {

/// The unsigned integer of so many bytes.
template <std::size_t kBytes>
using Bits = std::conditional_t<
    kBytes == 1, std::uint8_t,
    std::conditional_t<kBytes == 2, std::uint16_t,
                       std::conditional_t<kBytes == 4, std::uint32_t, std::uint64_t>>>;

/// The value whose bytes begin at `at`.
template <class T>
T load(const std::byte* at) {
  Bits<sizeof(T)> bits;
  std::memcpy(&bits, at, sizeof bits);
  if constexpr (std::endian::native == std::endian::big) {
    Bits<sizeof(T)> turned = 0;
    for (std::size_t b = 0; b < sizeof bits; ++b)
      turned = static_cast<Bits<sizeof(T)>>((turned << 8) | ((bits >> (8 * b)) & 0xffu));
    bits = turned;
  }
  return std::bit_cast<T>(bits);
}

}  // namespace orbweave::las
