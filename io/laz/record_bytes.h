// Values in the bytes of point records, which are little-endian and not aligned.
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>

#include "io/las/little_endian.h"

namespace orbweave::laz {

using las::load;

template <class T>
void store(std::byte* at, T value) {
  auto bits = std::bit_cast<las::Bits<sizeof(T)>>(value);
  if constexpr (std::endian::native == std::endian::little) {
    std::memcpy(at, &bits, sizeof bits);
  } else {
    for (std::size_t b = 0; b < sizeof bits; ++b)
      at[b] = static_cast<std::byte>((bits >> (8 * b)) & 0xffu);
  }
}

}  // namespace orbweave::laz
