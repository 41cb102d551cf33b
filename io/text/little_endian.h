// Values as binary formats hold them: little-endian, at any address, whatever the machine.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace orbweave {

/// The unsigned integer of this number of bytes.
template <std::size_t kBytes>
using Bits = std::conditional_t<
    kBytes == 1, std::uint8_t,
    std::conditional_t<kBytes == 2, std::uint16_t,
                       std::conditional_t<kBytes == 4, std::uint32_t, std::uint64_t>>>;

/// The value whose bytes begin at `at`.
template <class T>
T load_little(const std::byte* at) {
  Bits<sizeof(T)> bits = 0;
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(&bits, at, sizeof bits);
  } else {
    for (std::size_t b = sizeof bits; b-- > 0;)
      bits = static_cast<Bits<sizeof(T)>>((std::uint64_t{bits} << 8) |
                                          std::to_integer<std::uint64_t>(at[b]));
  }
  return std::bit_cast<T>(bits);
}

template <class T>
void store_little(std::byte* at, T value) {
  const auto bits = std::bit_cast<Bits<sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(at, &bits, sizeof bits);
  } else {
    for (std::size_t b = 0; b < sizeof bits; ++b)
      at[b] = static_cast<std::byte>((bits >> (8 * b)) & 0xffu);
  }
}

}  // namespace orbweave
