// How the memory budget is spent: chunk size, chunks in flight, buffers.
#pragma once

#include <cstddef>
#include <cstdint>

#include "io/point_cloud.h"

namespace orbweave {

/// Bytes a point costs at the peak of the stages, measured; docs/memory.md.
struct MemoryCosts {
  /// Reconstruction, as planned: positions, normals, cell grid, fans, triangles, and a margin for
  /// surfaces that cost more than most.
  static constexpr std::size_t kReconstructBytes = 320;
  /// The same as most surfaces take it.
  static constexpr std::size_t kUsualReconstructBytes = 275;
  /// Sorting a chunk: record as read, as sorted, keys.
  static std::size_t sort_bytes(const PointSchema& schema);
  /// Points of the cloud as they are read, before they have a place of their own.
  static std::size_t stream_bytes(const PointSchema& schema, int threads);
  /// The process before it holds any point: program, libraries, count grid.
  static constexpr std::size_t kBaseBytes = std::size_t{98} << 20;
};

struct MemoryPlan {
  std::uint64_t chunk_points = 0;  ///< most points of a chunk
  std::size_t chunks_in_flight_bytes = 0;
  std::size_t bin_buffer_bytes = 0;
};

/// Chooses the chunk size (unless `wanted_chunk_points` gives it, which is taken as far as the
/// budget has room for one such chunk, up to 2^28 points) and buffers. Chunks get at least
/// `worthwhile_points` where the budget allows: halos are computed twice. Throws Error
/// (resource) where the budget is below what the program needs, and says how much that is.
MemoryPlan plan_memory(std::uint64_t budget_bytes, std::uint64_t points, int threads,
                       std::uint64_t wanted_chunk_points, const PointSchema& schema,
                       std::uint64_t worthwhile_points = 0);

/// The smallest budget that plan_memory takes.
std::uint64_t least_budget_bytes(const PointSchema& schema, int threads);

}  // namespace orbweave
