// Which points of a block lie near a place, for several vector widths. Units compiled for other
// machines include this header: it defines nothing.
#pragma once

#include <cstdint>

namespace orbweave {

inline constexpr std::uint32_t kPointsPerBlock = 32;

/// What a scan finds.
struct NearInBlock {
  double squared[kPointsPerBlock];            ///< distances of all points of the block
  std::uint32_t listed[kPointsPerBlock + 4];  ///< points within the limit, ascending
  std::uint32_t count;                        ///< of them
};

/// Squared distances from (px, py, pz) to 32 points, and those of at most `limit`. Every form gives
/// the same bits.
using BlockScan = void (*)(const double* x, const double* y, const double* z, double px, double py,
                           double pz, double limit, NearInBlock& found);
void scan_block_generic(const double* x, const double* y, const double* z, double px, double py,
                        double pz, double limit, NearInBlock& found);
/// For machines with AVX2.
void scan_block_avx2(const double* x, const double* y, const double* z, double px, double py,
                     double pz, double limit, NearInBlock& found);
/// The fastest form that this machine runs.
BlockScan block_scan();

}  // namespace orbweave
