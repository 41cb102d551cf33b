// The loops of a search for nearest neighbours, for several vector widths. Units compiled for other
// machines include this header: it defines nothing.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine/geometry/vector_width.h"

namespace orbweave {

inline constexpr std::uint32_t kPointsPerBlock = 32;

inline constexpr std::uint32_t kPartsPerBlock = 4;

inline constexpr std::uint32_t kBoxesAtOnce = 8;

/// Positions in columns, in whole blocks; those behind the last point are no numbers. Of every
/// quarter of a block the box: low x, y, z, high x, y, z.
struct PositionColumns {
  const double* x = nullptr;
  const double* y = nullptr;
  const double* z = nullptr;
  const double* bounds[6] = {};
};

/// A vector's lanes, at most; columns have room for as many values more.
inline constexpr std::uint32_t kMostLanes = 8;

/// Blocks and their boxes, in columns: low x, y, z, high x, y, z.
struct BlockColumns {
  const double* bounds[6] = {};
  const std::uint32_t* block = nullptr;  ///< ascending
  std::uint32_t count = 0;
};

/// What is found.
struct FoundColumns {
  double* squared = nullptr;  ///< distances
  std::uint32_t* index = nullptr;
};

/// Every form gives the same bits.
struct NeighborKernel {
  /// Points of the blocks at squared distances of at most `limit` of a place, but for point `self`,
  /// ascending. Returns their number; `found` has room for all points of the blocks.
  std::uint32_t (*gather)(const PositionColumns& positions, const BlockColumns& blocks,
                          const double place[3], std::uint32_t self, double limit,
                          FoundColumns found);
  /// The `wanted` nearest of more than that, in their order; of equally distant ones the first.
  /// `from` has room for twice as many and 2 kMostLanes. Returns a limit within which they lie.
  double (*select)(FoundColumns from, std::uint32_t count, std::uint32_t wanted, FoundColumns to);
  /// Which of the kBoxesAtOnce boxes from `first` on come within a squared distance of `limit` of a
  /// box: a bit for each. Boxes are columns as blocks' are.
  unsigned (*near_boxes)(const double* const bounds[6], std::size_t first, const double low[3],
                         const double high[3], double limit);
};

NeighborKernel neighbor_kernel_generic();
/// For machines with AVX2.
NeighborKernel neighbor_kernel_avx2();
/// For machines with AVX-512.
NeighborKernel neighbor_kernel_avx512();
NeighborKernel neighbor_kernel(VectorWidth width);

}  // namespace orbweave
