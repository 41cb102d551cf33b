#include "engine/pipeline/partition_stage.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <mutex>

#include "engine/ball_pivoting/automatic_radii.h"
#include "engine/ball_pivoting/ball_pivoting.h"
#include "io/chunk_points.h"
#include "partition/binning.h"
#include "partition/canonical_order.h"
#include "partition/count_grid.h"
#include "partition/memory_plan.h"

namespace orbweave {
namespace {

constexpr const char* kDocument = "partition";

void add_counts(DroppedPoints& to, const DroppedPoints& from) {
  for (const auto& [reason, count] : from) to[reason] += count;
}

/// Attributes that nobody will write are not carried.
void strip(PointCloud& points, const OutputOptions& output) {
  if (output.attributes || points.schema.attributes.empty()) return;
  points.schema.attributes.clear();
  points.attributes.clear();
}

PointSchema carried(PointSchema schema, const OutputOptions& output) {
  if (!output.attributes) schema.attributes.clear();
  return schema;
}

std::string no_points_reason(const DroppedPoints& dropped) {
  std::string text = "no usable point";
  for (const auto& [reason, count] : dropped)
    text += "; " + std::to_string(count) + " dropped: " + reason;
  return text;
}

/// A chunk whose side is eight halos computes about half as much again for its halo.
constexpr double kHalosPerSide = 8.0;

/// How many points a chunk needs so that its halo is not most of the work: the points of a piece
/// of surface of that side. The surface is guessed from the cells that hold points.
std::uint64_t worthwhile_chunk_points(const CountGrid& grid, const ReconstructOptions& options) {
  std::vector<double> radii = options.ball_radii;
  double points_per_area = 1.0;
  if (radii.empty()) {
    // Automatic radii are so many spacings; a spacing squared holds a point.
    radii.push_back(kRadiusPerSpacing);
    for (int level = 1; level < options.levels; ++level) {
      radii.push_back(radii.back() * kRadiusGrowth);
    }
  } else {
    std::uint64_t cells = 0;
    grid.for_each([&](Vec3, std::uint64_t) { ++cells; });
    points_per_area = static_cast<double>(grid.points()) /
                      (static_cast<double>(cells) * grid.cell() * grid.cell());
  }
  const double side = kHalosPerSide * halo_width(radii);
  const double wanted = side * side * points_per_area;
  return static_cast<std::uint64_t>(std::min(wanted, static_cast<double>(grid.points())));
}

/// Second pass: every point goes to the bin of its chunk.
void bin_points(JobContext& context, const CountedCloud& cloud, Binner& binner,
                SpacingSampler& sampler) {
  const auto source = open_input(context);
  StageClock clock(context, "bin", cloud.points_read, "points");
  std::uint64_t points_read = 0;
  stream_points(
      *source, {.threads = context.threads(), .stop = &context.stop},
      [&](StreamBatch& batch) {
        strip(batch.points, context.job.output);
        batch.chunks.resize(batch.points.size());
        for (std::size_t i = 0; i < batch.points.size(); ++i) {
          batch.chunks[i] = cloud.octree.chunk_of(batch.points.positions[i]);
        }
      },
      [&](StreamBatch& batch) {
        binner.add(batch.points, batch.chunks);
        sampler.add(batch.points.positions);
        points_read += batch.points_read;
        context.progress.advance(batch.points_read);
        context.progress.add_points(batch.points_read);
      });
  if (points_read != cloud.points_read) {
    throw_bad_input("the input changed while it was read",
                    {.file = context.files.front(),
                     .place = {},
                     .found = std::to_string(points_read) + " points",
                     .expected = std::to_string(cloud.points_read),
                     .advice = "Run the same command again"});
  }
  clock.facts().points = points_read;
  clock.facts().bytes_read = source->bytes_total();
  clock.facts().bytes_written = binner.spilled_bytes();
}

/// Sorts every bin canonically and commits it.
void sort_chunks(JobContext& context, const CountedCloud& cloud, Binner& binner,
                 Partition& partition) {
  const auto& chunks = cloud.octree.chunks();
  StageClock clock(context, "sort", chunks.size(), "chunks");
  std::vector<ChunkTask> tasks;
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    tasks.push_back({chunk, binner.points(chunk) * MemoryCosts::sort_bytes(cloud.schema)});
  }
  std::vector<std::uint64_t> kept(chunks.size(), 0);
  std::atomic<std::uint64_t> merged{0};
  run_chunks(tasks, {context.threads(), cloud.memory.chunks_in_flight_bytes / 2, &context.stop},
             [&](ChunkId chunk) {
               PointCloud points = binner.take(chunk);
               merged += sort_canonically(points, cloud.octree.root());
               kept[chunk] = points.size();
               commit_points(context.store, chunk, points);
               context.progress.advance(1);
               context.progress.add_points(points.size());
             });
  partition.first_vertex.assign(1, 0);
  for (const std::uint64_t count : kept) {
    partition.first_vertex.push_back(partition.first_vertex.back() + count);
  }
  if (merged > 0) partition.dropped["exact duplicate"] += merged;
  clock.facts().points = cloud.points_used;
  clock.facts().chunks = chunks.size();
}

std::string file_stamp(const std::string& file) {
  std::error_code ignored;
  const auto size = std::filesystem::file_size(file, ignored);
  const auto time = std::filesystem::last_write_time(file, ignored).time_since_epoch().count();
  return file + "|" + std::to_string(size) + "|" + std::to_string(time);
}

}  // namespace

std::unique_ptr<PointSource> open_input(const InputContext& context,
                                        std::vector<std::string>* notes) {
  std::vector<std::filesystem::path> paths(context.files.begin(), context.files.end());
  const auto opener = [&options = context.job.input](const std::filesystem::path& path) {
    return open_point_source(path, {options.text});
  };
  auto source = open_point_sources(paths, opener, notes);
  if (!source->schema().has_normals) {
    throw_bad_input("the cloud has no normals",
                    {.file = context.files.front(),
                     .place = {},
                     .found = "points without nx, ny, nz",
                     .expected = "a normal per point",
                     .advice = "This version does not estimate normals; make an oriented cloud of "
                               "a mesh with: orbweave convert --normals-from-faces MESH CLOUD"});
  }
  return source;
}

CountedCloud count_points(const InputContext& context) {
  CountedCloud cloud;
  const auto source = open_input(context, &cloud.notes);
  cloud.schema = carried(source->schema(), context.job.output);
  stream_points(*source, {.threads = context.threads(), .stop = &context.stop}, {},
                [&](StreamBatch& batch) {
                  cloud.grid.add(batch.points.positions);
                  cloud.points_read += batch.points_read;
                  add_counts(cloud.dropped, batch.dropped);
                  context.progress.advance(batch.points_read);
                  context.progress.add_points(batch.points_read);
                });
  cloud.bytes_read = source->bytes_total();
  cloud.points_used = cloud.grid.points();
  if (cloud.points_used == 0) {
    throw_bad_input(
        cloud.points_read == 0 ? "the cloud holds no points" : no_points_reason(cloud.dropped),
        {.file = context.files.front()});
  }
  const RootCube root = root_cube(cloud.grid.bounds());
  cloud.grid.settle(root.side);
  cloud.memory = plan_memory(context.job.partition.memory_bytes, cloud.points_used,
                             context.threads(), context.job.partition.chunk_points, cloud.schema,
                             worthwhile_chunk_points(cloud.grid, context.job.reconstruct));
  cloud.octree = cut_octree(cloud.grid, root, cloud.memory.chunk_points);
  return cloud;
}

std::string partition_key(const Job& job, const std::vector<std::string>& files) {
  std::string key = "orbweave points 1\n";
  for (const std::string& file : files) key += file_stamp(file) + "\n";
  for (const std::string& column : job.input.text.columns) key += "column " + column + "\n";
  key += "separator " + std::to_string(job.input.text.separator) + "\n";
  key += "memory " + std::to_string(job.partition.memory_bytes) + "\n";
  key += "chunk_points " + std::to_string(job.partition.chunk_points) + "\n";
  key += "attributes " + std::to_string(job.output.attributes) + "\n";
  const bool automatic = job.reconstruct.ball_radii.empty();
  key += "levels " + std::to_string(automatic ? job.reconstruct.levels : 0) + "\n";
  return key;
}

std::optional<Partition> stored_partition(const ChunkStore& store) {
  const auto document = store.document(kPointsStage, kDocument);
  if (!document) return std::nullopt;
  return partition_from_json(*document);
}

Partition partition_points(JobContext& context) {
  if (context.store.begin_stage(kPointsStage, partition_key(context.job, context.files))) {
    if (std::optional<Partition> partition = stored_partition(context.store)) {
      context.note("resuming: the points are partitioned already");
      return std::move(*partition);
    }
  }
  CountedCloud cloud;
  {
    StageClock clock(context, "count", 0, "points");
    cloud = count_points(context);
    clock.facts().points = cloud.points_read;
    clock.facts().bytes_read = cloud.bytes_read;
  }
  for (const std::string& line : cloud.notes) context.note(line);
  Partition partition;
  partition.bounds = cloud.grid.bounds();
  SpacingSampler sampler(cloud.octree.root(), cloud.grid);
  cloud.grid = CountGrid();
  Binner binner(cloud.octree, cloud.schema,
                {cloud.memory.bin_buffer_bytes, context.store.directory()});
  bin_points(context, cloud, binner, sampler);
  const RadiiChoice choice = sampler.choose(std::max(1, context.job.reconstruct.levels));
  partition.spacing = choice.spacing;
  partition.automatic_radii = choice.radii;
  partition.radii_reason = choice.reason;
  partition.schema = cloud.schema;
  partition.points_read = cloud.points_read;
  partition.dropped = cloud.dropped;
  partition.octree = cloud.octree;
  sort_chunks(context, cloud, binner, partition);
  context.store.finish_commits();
  context.store.commit_document(kPointsStage, kDocument, partition_to_json(partition));
  return partition;
}

}  // namespace orbweave
