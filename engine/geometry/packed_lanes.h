// Which lanes of a vector of four are in a mask, for units that are compiled once per vector width.
#pragma once

#include <cstdint>

namespace orbweave {
namespace {  // every including unit is compiled for another machine: nothing may be shared

/// For each mask of four lanes the lanes of it, in order, and then any others; whole and as pairs
/// of halves.
struct PackedLanes {
  alignas(16) std::int32_t lanes[16][4] = {};
  alignas(32) std::int32_t halves[16][8] = {};
  constexpr PackedLanes() {
    for (int mask = 0; mask < 16; ++mask) {
      int to = 0;
      for (int from = 0; from < 4; ++from) {
        if ((mask >> from & 1) == 0) continue;
        lanes[mask][to] = from;
        halves[mask][2 * to] = 2 * from;
        halves[mask][2 * to++ + 1] = 2 * from + 1;
      }
    }
  }
};
inline constexpr PackedLanes kPackedLanes;

}  // namespace
}  // namespace orbweave
