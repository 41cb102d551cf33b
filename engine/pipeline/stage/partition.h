// How the points of a job lie in chunks: what the later stages know of the points.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/pipeline/stage/said_line.h"
#include "engine/spacing/layer_thickness.h"
#include "io/report/report.h"
#include "io/store/chunk_points.h"
#include "partition/octree.h"

namespace orbweave {

/// Stored as a document beside the points.
struct Partition {
  PointSchema schema;
  Box bounds;
  Octree octree;
  std::vector<std::uint64_t> first_vertex;  ///< global number of each chunk's first point; + total
  std::uint64_t memory_bytes = 0;           ///< budget that the chunks were made for
  std::uint64_t points_read = 0;
  DroppedPoints dropped;
  double spacing = 0.0;  ///< robust nearest-neighbour spacing; 0: unknown
  std::vector<double> automatic_radii;
  std::string radii_reason;
  double spacing_by_area = 0.0;    ///< RadiiChoice::spacing_by_area; 0: not measured
  double sparse_offset = 0.0;      ///< of the points that automatic radii grow for (RadiiChoice)
  std::size_t line_neighbors = 0;  ///< RadiiChoice::line_neighbors
  LayerThickness layers;           ///< of the scans as they came; not measured elsewhere
  double coordinate_step = 0.0;    ///< of the scans' coordinates (coordinate_step); 0: fine
  double common_step = 0.0;        ///< likewise (common_step)
  double normal_radius = 0.0;      ///< within which the neighbours for a normal are found; likewise
  std::uint64_t points_without_view = 0;  ///< points whose scanner is not known
  CleaningFacts cleaning;
  NormalFacts normals;
  std::string coordinate_system;
  std::optional<Vec3> meters_per_unit;  ///< of x, y and z; empty: not known
  bool has_wide_colors = false;         ///< 16-bit colours of the scans beyond 255
  /// What was said of the points when they were made; runs that find them made say it again.
  std::vector<SaidLine> said;
  /// Where the store holds the points; not part of the document.
  std::string stage = kPointsStage;

  std::uint64_t points_in(ChunkId chunk) const {
    return first_vertex[chunk + 1] - first_vertex[chunk];
  }
  /// The chunk that a point belongs to, by its global number.
  ChunkId chunk_of(std::uint64_t vertex) const;
  std::uint64_t points() const { return first_vertex.back(); }
};

std::string partition_to_json(const Partition& partition);
Partition partition_from_json(const std::string& text);

/// What an earlier run left; empty: nothing whole.
std::optional<Partition> stored_partition(const ChunkStore& store,
                                          const std::string& stage = kPointsStage);
/// The partition that is known to be there. Throws CorruptResult where it is not.
Partition expected_partition(const ChunkStore& store, const std::string& stage);
void commit_partition(ChunkStore& store, const std::string& stage, const Partition& partition);

/// "5 points read; 3 dropped: zero normal, 2 dropped: outlier"; for messages.
std::string describe_dropped(std::uint64_t read, const DroppedPoints& dropped);

/// Throws Error (bad input) where the points that are left of a job's scans are fewer than three.
/// `file`: the first scan.
void require_a_triangle(const std::string& file, std::uint64_t points, std::uint64_t read,
                        const DroppedPoints& dropped);

}  // namespace orbweave
