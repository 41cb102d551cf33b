#include "engine/pipeline/points/placeholder_normals.h"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "io/store/chunk_points.h"

namespace orbweave {
namespace {

/// Of so many chunks some rows are looked at before all points are.
constexpr std::size_t kFewChunks = 16;
constexpr std::uint64_t kFewRows = 4096;
constexpr std::uint64_t kRowsAtATime = std::uint64_t{1} << 16;
/// Noisy points of a plane lie within fewer spacings of it.
constexpr double kFlatSpacings = 10.0;

/// The points seen so far.
struct Seen {
  std::optional<Vec3> normal;
  double lowest = std::numeric_limits<double>::infinity();  ///< along it
  double highest = -std::numeric_limits<double>::infinity();

  /// False where a normal differs.
  bool add(const PointCloud& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!normal) normal = points.normals[i];
      if (!(points.normals[i] == *normal)) return false;
      const double along = dot(points.positions[i], normalized(*normal));
      lowest = std::min(lowest, along);
      highest = std::max(highest, along);
    }
    return true;
  }
};

/// Whether points that lie apart from each other, and would tell most scans, have one normal.
bool seem_all_the_same(const ChunkStore& store, const Partition& partition,
                       const PointSchema& schema) {
  Seen seen;
  PointCloud points;
  const std::size_t chunks = partition.octree.chunks().size();
  const std::size_t looks = std::min(chunks, kFewChunks);
  for (std::size_t look = 0; look < looks; ++look) {
    const auto chunk = static_cast<ChunkId>(look * chunks / looks);
    // In canonical order the beginning, the middle and the end of a chunk lie apart.
    const std::uint64_t in_chunk = partition.points_in(chunk);
    const std::uint64_t rows = std::min(in_chunk, kFewRows);
    for (const std::uint64_t first : {std::uint64_t{0}, (in_chunk - rows) / 2, in_chunk - rows}) {
      load_point_rows(store, chunk, schema, first, rows, points, partition.stage);
      if (!seen.add(points)) return false;
    }
  }
  return true;
}

}  // namespace

std::optional<Vec3> placeholder_normal(const ChunkStore& store, const Partition& partition,
                                       const StopToken& stop) {
  PointSchema schema = partition.schema;
  schema.attributes.clear();
  if (!schema.has_normals || !(partition.spacing > 0.0)) return std::nullopt;
  if (!seem_all_the_same(store, partition, schema)) return std::nullopt;
  Seen seen;
  PointCloud points;
  for (ChunkId chunk = 0; chunk < partition.octree.chunks().size(); ++chunk) {
    const std::uint64_t in_chunk = partition.points_in(chunk);
    for (std::uint64_t first = 0; first < in_chunk; first += kRowsAtATime) {
      stop.check();
      const std::uint64_t rows = std::min(kRowsAtATime, in_chunk - first);
      load_point_rows(store, chunk, schema, first, rows, points, partition.stage);
      if (!seen.add(points)) return std::nullopt;
    }
  }
  const bool is_flat = !(seen.highest - seen.lowest > kFlatSpacings * partition.spacing);
  return is_flat ? std::nullopt : seen.normal;
}

}  // namespace orbweave
