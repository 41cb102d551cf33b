// Point records that try the LAZ coder: bytes at random, and points as scanners make them.
#pragma once

#include <cstdint>
#include <vector>

#include "tests/io/laz_encoder.h"

namespace orbweave::test {

/// Every byte at random: all return numbers, channels and widths of differences.
std::vector<std::uint8_t> random_records(const LazOptions& options, std::size_t points,
                                         std::uint64_t seed);

/// Small steps, repeated attributes, four interleaved clocks, rare jumps of anything.
std::vector<std::uint8_t> scan_records(const LazOptions& options, std::size_t points,
                                       std::uint64_t seed);

}  // namespace orbweave::test
