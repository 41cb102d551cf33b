// The columns of the output's vertices, and how rows of them are read.
#pragma once

#include <cstdint>
#include <string>

#include "engine/pipeline/stage/partition.h"
#include "io/job/job.h"
#include "io/points/color_depth.h"
#include "io/store/chunk_points.h"
#include "io/store/chunk_store.h"

namespace orbweave {

/// Column of OutputOptions::vertex_undersampled: 1 where sampling is too sparse for the shape, 0
/// elsewhere, kNoSample where there was no point.
inline constexpr const char* kUndersampledColumn = "undersampled";
inline constexpr std::uint8_t kNoSample = 255;

/// The columns of vertices: those of the stored points that are wanted, and what becomes of them in
/// the file.
struct VertexColumns {
  PointSchema stored;
  bool undersampled = false;  ///< a last column that the method's results tell
  ColorDepth colors;          ///< of the stored columns and that one

  const PointSchema& written() const { return colors.written(); }
};

VertexColumns vertex_columns(const Partition& partition, const OutputOptions& output);

/// Rows [first, first + count) of a chunk's vertices, which `stage` has, with the column that the
/// method tells.
void load_vertex_rows(const ChunkStore& store, const std::string& stage, ChunkId chunk,
                      const VertexColumns& columns, std::uint64_t first, std::uint64_t count,
                      PointCloud& points);

/// Adds that column to vertices of patches, where the columns have it.
void mark_unsampled(const VertexColumns& columns, PointCloud& vertices);

/// How many of `count` points are best read with the first: those that follow closely in the file
/// of its chunk, which ends before point `chunk_end`, no more than `most_rows` rows away.
/// `number_of(i)` is the number of a point.
template <class NumberOf>
std::size_t read_at_once(std::size_t count, const NumberOf& number_of, std::uint64_t chunk_end,
                         std::uint64_t most_rows) {
  const std::uint64_t first = number_of(0);
  std::size_t together = 1;
  for (; together < count; ++together) {
    const std::uint64_t before = number_of(together - 1), next = number_of(together);
    if (next < before || next - before > kPointBlockRows || next >= chunk_end) break;
    if (next - first >= most_rows) break;
  }
  return together;
}

}  // namespace orbweave
