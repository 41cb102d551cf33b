// Points of a chunk in the chunk store: whole, or the part of them that lies in a box.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/store/chunk_store.h"

namespace orbweave {

inline constexpr const char* kPointsStage = "points";

// Every function below takes the stage that the points belong to: kPointsStage, or one of those
// that raw scans pass through before (docs/dev/chunk-store.md).

/// Rows per block of the index that the box query uses.
inline constexpr std::uint32_t kPointBlockRows = 1024;

/// Commits a chunk's points, in the order given, with a bounding box per kPointBlockRows rows.
/// Normals are stored at schema.normal_type, attributes as packed rows. `source_rows` (one per
/// point, or none) are stored beside them: where each was among the points that the stage took. So
/// are `beside`, arrays of other names that belong to the points.
void commit_points(ChunkStore& store, ChunkId chunk, const PointCloud& points,
                   const std::string& stage = kPointsStage,
                   std::span<const std::uint32_t> source_rows = {},
                   std::span<const ArrayView> beside = {});

/// Reads all points of a chunk.
PointCloud load_points(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                       const std::string& stage = kPointsStage);

/// The rows that a chunk's points were committed with; empty without.
std::vector<std::uint32_t> load_source_rows(const ChunkStore& store, ChunkId chunk,
                                            const std::string& stage);

/// Number of points of a chunk.
std::uint64_t stored_points(const ChunkStore& store, ChunkId chunk,
                            const std::string& stage = kPointsStage);

/// Bounds of every kPointBlockRows rows of a chunk's points, in their order.
std::vector<Box> stored_block_bounds(const ChunkStore& store, ChunkId chunk,
                                     const std::string& stage = kPointsStage);

/// Reads rows [first, first + count) of a chunk's points.
PointCloud load_point_rows(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                           std::uint64_t first, std::uint64_t count,
                           const std::string& stage = kPointsStage);
/// The same to a cloud whose memory is used again.
void load_point_rows(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                     std::uint64_t first, std::uint64_t count, PointCloud& points,
                     const std::string& stage = kPointsStage);

/// Positions and normals of all points of a chunk, to where they are wanted: as many as it has.
void load_oriented_points(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                          std::span<Vec3> positions, std::span<Vec3> normals,
                          const std::string& stage = kPointsStage);

/// What is read besides positions.
struct PointParts {
  bool normals = true;
  bool attributes = false;
};

/// Points of a chunk that lie in the closed box, with their row numbers (ascending). Reads only
/// the blocks whose bounds meet the box. The result's schema has the parts asked for.
struct PointsInBox {
  PointCloud points;
  std::vector<std::uint32_t> rows;
};
PointsInBox load_points_in_box(const ChunkStore& store, ChunkId chunk, const PointSchema& schema,
                               const Box& box, PointParts parts = {},
                               const std::string& stage = kPointsStage);

}  // namespace orbweave
