// CRC-32C, the checksum of the pages of E57.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace orbweave {

/// CRC-32C (Castagnoli: polynomial 0x1EDC6F41, reflected, start and end inverted) as in RFC 3720,
/// appendix B.4. Eight bytes per step, from tables.
std::uint32_t crc32c(std::span<const std::byte> bytes);

}  // namespace orbweave
