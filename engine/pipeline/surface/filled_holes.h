// What the hole stage changes of the stitched mesh.
#pragma once

#include <compare>
#include <cstdint>
#include <vector>

#include "engine/pipeline/surface/vertex_numbering.h"
#include "io/report/report.h"
#include "io/triangle_mesh.h"

namespace orbweave {

/// A corner of a triangle that is to use a copy of its vertex.
struct SplitCorner {
  Triangle64 triangle{};  ///< as stored; new vertices are kNewVertex + index over all batches
  std::uint64_t vertex = 0;
  CopyIndex copy{};
  friend auto operator<=>(const SplitCorner&, const SplitCorner&) = default;
};

/// Vertices are the job's, in canonical order.
struct FilledHoles {
  std::vector<HoleFacts> holes;              ///< all loops, in canonical order
  std::vector<std::uint64_t> new_vertices;   ///< per batch
  std::vector<std::uint64_t> new_triangles;  ///< per batch
  std::uint64_t pieces_removed = 0;          ///< pieces that are too small
  std::vector<Triangle64> removed;           ///< of these, and where it was mended, sorted
  std::uint64_t flaps = 0;                   ///< of these: RimFlaps
  std::vector<std::uint64_t> freed;          ///< vertices that only they used, ascending
  std::vector<SplitCorner> splits;           ///< sorted
  std::vector<std::uint64_t> copies;         ///< per copy the vertex that it doubles
};

/// The split of this corner; null where there is none.
const SplitCorner* find_split(const FilledHoles& holes, const Triangle64& triangle,
                              std::uint64_t vertex);

}  // namespace orbweave
