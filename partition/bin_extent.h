// A piece of a spill file with points of one bin.
#pragma once

#include <cstdint>

namespace orbweave {

/// A piece of a bin in a spill file.
struct BinExtent {
  std::uint64_t chunk = 0;
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;  ///< XXH3-64
};

}  // namespace orbweave
