#include "io/clouds/e57/crc32c.h"

#include <array>

namespace orbweave {
namespace {

using Table = std::array<std::uint32_t, 256>;

/// tables[k][b]: what byte b does to the remainder after k more bytes.
constexpr std::array<Table, 8> make_tables() {
  constexpr std::uint32_t kReflectedPolynomial = 0x82F63B78u;
  std::array<Table, 8> tables{};
  for (std::uint32_t value = 0; value < 256; ++value) {
    std::uint32_t remainder = value;
    for (int bit = 0; bit < 8; ++bit)
      remainder = (remainder >> 1) ^ ((remainder & 1u) != 0 ? kReflectedPolynomial : 0u);
    tables[0][value] = remainder;
  }
  for (std::size_t k = 1; k < tables.size(); ++k)
    for (std::size_t value = 0; value < 256; ++value) {
      const std::uint32_t before = tables[k - 1][value];
      tables[k][value] = (before >> 8) ^ tables[0][before & 0xFFu];
    }
  return tables;
}

constexpr std::array<Table, 8> kTables = make_tables();

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes) {
  const auto byte_at = [&](std::size_t i) { return static_cast<std::uint32_t>(bytes[i]); };
  std::uint32_t crc = 0xFFFFFFFFu;
  std::size_t i = 0;
  for (; bytes.size() - i >= 8; i += 8) {
    crc ^= byte_at(i) | byte_at(i + 1) << 8 | byte_at(i + 2) << 16 | byte_at(i + 3) << 24;
    crc = kTables[7][crc & 0xFFu] ^ kTables[6][crc >> 8 & 0xFFu] ^ kTables[5][crc >> 16 & 0xFFu] ^
          kTables[4][crc >> 24] ^ kTables[3][byte_at(i + 4)] ^ kTables[2][byte_at(i + 5)] ^
          kTables[1][byte_at(i + 6)] ^ kTables[0][byte_at(i + 7)];
  }
  for (; i < bytes.size(); ++i) crc = (crc >> 8) ^ kTables[0][(crc ^ byte_at(i)) & 0xFFu];
  return ~crc;
}

}  // namespace orbweave
