// The columns of the output's vertices, and how rows of them are read.
#pragma once

#include <cstdint>
#include <string>

#include "engine/pipeline/stage/partition.h"
#include "io/job/job.h"
#include "io/points/color_depth.h"
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

}  // namespace orbweave
