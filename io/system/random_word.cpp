#include "io/system/random_word.h"

#include <cstdint>
#include <random>

#include "io/hex_digits.h"

namespace orbweave {

std::string random_word() {
  std::random_device device;
  const std::uint64_t high = device();
  return hex_digits(high << 32 | device());
}

}  // namespace orbweave
