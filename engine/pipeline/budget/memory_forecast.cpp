#include "engine/pipeline/budget/memory_forecast.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "engine/ball_pivoting/ball_pivoting.h"
#include "engine/pipeline/stage/cleaning_rule.h"
#include "engine/pipeline/stage/method_costs.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/store/chunk_points.h"
#include "io/text/quantity.h"
#include "io/whole_loop.h"

namespace orbweave {
namespace {

/// Of the process while it reads and bins, and afterwards, beside the points; measured.
constexpr std::uint64_t kReadingBytes = std::uint64_t{74} << 20;
constexpr std::uint64_t kWorkingBytes = std::uint64_t{64} << 20;
/// Count grid and sample of the points, which grow with them up to a limit; measured.
constexpr std::uint64_t kSampleBytesPerPoint = 2;
constexpr std::uint64_t kMostSampleBytes = std::uint64_t{16} << 20;
/// As measured: a point of a chunk that is sorted, in records.
constexpr std::uint64_t kRecordsPerSorted = 2;
constexpr double kMargin = 1.06;
/// What passes over raw points leave behind, with the graph of their patches; measured.
constexpr std::uint64_t kPassBytes = std::uint64_t{8} << 20;
constexpr std::uint64_t kPassBytesPerPoint = 2;
/// Block bounds, checksums, shapes, chunks: per 64 points.
constexpr std::uint64_t kWholeCloudBytesPer64 = 16;
/// As measured: the boundary while it is stitched and traced, and while holes are filled.
constexpr std::uint64_t kTracedEdgeBytes = 165;
constexpr std::uint64_t kTracedLoopBytes = 280;
constexpr std::uint64_t kFilledEdgeBytes = 56;
constexpr std::uint64_t kFilledLoopBytes = 340;
/// Where no holes are filled: fans, and what counting loops takes beside them.
constexpr std::uint64_t kCountedEdgeBytes = 40;
/// A piece, its number and its place among those it hangs together with; a copy while loops are
/// traced.
constexpr std::uint64_t kPieceBytes = 144;

std::uint64_t record_bytes(const PointSchema& schema) {
  return sizeof(Vec3) + schema.attribute_bytes() +
         (schema.has_normals ? 3 * size_of(schema.normal_type) : 0);
}

/// What chunks in flight take: the longest first, as the executor starts them.
std::uint64_t in_flight_bytes(std::vector<std::uint64_t> points, int threads,
                              std::uint64_t limit_bytes, std::uint64_t planned_per_point,
                              std::uint64_t used_per_point) {
  std::sort(points.begin(), points.end(), std::greater<>());
  std::uint64_t sum = 0;
  for (int i = 0; i < threads && static_cast<std::size_t>(i) < points.size(); ++i) {
    const std::uint64_t next = sum + points[static_cast<std::size_t>(i)];
    if (i > 0 && next * planned_per_point > limit_bytes) break;
    sum = next;
  }
  return std::min(sum * used_per_point,
                  std::max(limit_bytes, points.empty() ? 0 : points[0] * used_per_point));
}

/// The finest chunks hold one place: their duplicates are merged before anything else.
std::uint64_t distinct_points(const Chunk& chunk) {
  return chunk.depth == kMortonDepth ? 1 : chunk.points;
}

/// While points with that schema are cut into chunks.
std::uint64_t partition_peak(const ResolvedJob& job, const Partition& partition,
                             const PointSchema& schema, const MemoryPlan& plan) {
  const std::uint64_t record = record_bytes(schema);
  const std::uint64_t bins =
      std::min<std::uint64_t>(plan.bin_buffer_bytes, partition.octree.points() * record);
  const std::uint64_t base = kReadingBytes + MemoryCosts::stream_bytes(schema, job.threads());
  std::vector<std::uint64_t> points;
  for (const Chunk& chunk : partition.octree.chunks()) points.push_back(chunk.points);
  const std::uint64_t sorting =
      in_flight_bytes(std::move(points), job.threads(), plan.chunks_in_flight_bytes / 2,
                      MemoryCosts::sort_bytes(schema), kRecordsPerSorted * record);
  const std::uint64_t sample =
      std::min(partition.octree.points() * kSampleBytesPerPoint, kMostSampleBytes);
  return base + sample + bins + sorting;
}

/// While cleaned points are cut into chunks. All raw points may be left, with normals by then.
std::uint64_t cleaned_peak(const ResolvedJob& job, const Partition& partition,
                           const MemoryPlan& plan) {
  if (!job.needs_cleaning_or_normals()) return 0;
  PointSchema schema = partition.schema;
  if (!schema.has_normals) schema.normal_type = ScalarType::kFloat32;
  schema.has_normals = true;
  return partition_peak(job, partition, schema, plan) + kPassBytes +
         kPassBytesPerPoint * partition.octree.points();
}

/// What the method holds at once beside what every job holds.
std::uint64_t bytes_of_method(const ResolvedJob& job, const Partition& partition) {
  const std::uint64_t per_point = costs_of(job.reconstruct.method).bytes_per_point;
  if (!is_super_cocone(job, partition)) return partition.octree.points() * per_point;
  std::vector<std::uint64_t> points;
  for (const Chunk& chunk : partition.octree.chunks()) {
    points.push_back(
        static_cast<std::uint64_t>(kGrownCoconeBox * static_cast<double>(distinct_points(chunk))));
  }
  const MemoryPlan plan = job.memory_plan(partition.octree.points(), partition.schema);
  return in_flight_bytes(std::move(points), job.threads(), plan.chunks_in_flight_bytes, per_point,
                         per_point);
}

/// The points of a chunk and its halo, as if the points of each neighbour filled the cube evenly.
double points_around(const Partition& partition, ChunkId self, double halo_width) {
  const std::vector<Chunk>& chunks = partition.octree.chunks();
  const Box reach = chunks[self].box.grown(halo_width);
  auto points = static_cast<double>(chunks[self].points);
  for (const ChunkId other : partition.octree.neighbors(self, halo_width)) {
    const Box& box = chunks[other].box;
    double share = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = std::max(reach.min[axis], box.min[axis]);
      const double high = std::min(reach.max[axis], box.max[axis]);
      share *= std::clamp((high - low) / (box.max[axis] - box.min[axis]), 0.0, 1.0);
    }
    points += share * static_cast<double>(chunks[other].points);
  }
  return points;
}

}  // namespace

std::vector<std::uint64_t> points_with_halos(const ChunkStore& store, const Partition& partition,
                                             double halo_width) {
  const std::vector<Chunk>& chunks = partition.octree.chunks();
  std::vector<std::vector<Box>> blocks(chunks.size());
  for_each_whole(chunks.size(), [&](std::size_t chunk) {
    blocks[chunk] = stored_block_bounds(store, static_cast<ChunkId>(chunk), partition.stage);
  });
  std::vector<std::uint64_t> points;
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const Box reach = chunks[chunk].box.grown(halo_width);
    points.push_back(partition.points_in(chunk));
    for (const ChunkId other : partition.octree.neighbors(chunk, halo_width)) {
      const auto met = std::count_if(blocks[other].begin(), blocks[other].end(),
                                     [&](const Box& box) { return box.intersects(reach); });
      points.back() +=
          std::min(partition.points_in(other), static_cast<std::uint64_t>(met) * kPointBlockRows);
    }
  }
  return points;
}

std::vector<std::uint64_t> expected_points_with_halos(const Partition& partition,
                                                      double halo_width) {
  const double halo =
      partition.spacing > 0.0 ? halo_width / partition.spacing : 0.0;  // in spacings
  const auto all = static_cast<double>(partition.octree.points());
  const std::vector<Chunk>& chunks = partition.octree.chunks();
  std::vector<std::uint64_t> points;
  for (ChunkId chunk = 0; chunk < chunks.size(); ++chunk) {
    const double side = std::sqrt(static_cast<double>(distinct_points(chunks[chunk]))) + 2.0 * halo;
    const double around = points_around(partition, chunk, halo_width);
    points.push_back(static_cast<std::uint64_t>(std::min(std::max(side * side, around), all)));
  }
  return points;
}

std::uint64_t most_points_with_halo(const ResolvedJob& job) {
  const std::uint64_t budget = job.partition.memory_bytes;
  return (budget - std::min(budget, kWorkingBytes)) / MemoryCosts::kUsualReconstructBytes;
}

std::uint64_t predicted_peak_bytes(const ResolvedJob& job, const Partition& partition,
                                   std::span<const double> radii) {
  const std::uint64_t points = partition.octree.points();
  const MemoryPlan plan = job.memory_plan(points, partition.schema);
  const bool has_halos = !radii.empty() && !is_in_core(job.reconstruct.method);
  const double reach =
      std::max(has_halos ? halo_width(radii) : 0.0, reach_of_cleaning(job, partition));
  const std::uint64_t in_flight = in_flight_bytes(
      expected_points_with_halos(partition, reach), job.threads(), plan.chunks_in_flight_bytes,
      MemoryCosts::kReconstructBytes, MemoryCosts::kUsualReconstructBytes);
  const std::uint64_t whole = points * kWholeCloudBytesPer64 / 64;
  const std::uint64_t peak = std::max(
      {partition_peak(job, partition, partition.schema, plan), cleaned_peak(job, partition, plan),
       kWorkingBytes + in_flight + whole, kWorkingBytes + bytes_of_method(job, partition),
       kWorkingBytes + points * costs_of(job.normals.source).bytes_per_point});
  return std::min(static_cast<std::uint64_t>(kMargin * static_cast<double>(peak)),
                  std::max(job.partition.memory_bytes, peak));
}

namespace {

std::uint64_t whole_cloud_bytes(const Partition& partition) {
  return kWorkingBytes + partition.octree.points() * kWholeCloudBytesPer64 / 64;
}

/// While loops are traced, which no chunk is held beside.
std::uint64_t traced_bytes(const HoleLoad& load) {
  return load.edges * kTracedEdgeBytes + load.loops * kTracedLoopBytes + load.pieces * kPieceBytes;
}

std::uint64_t filled_bytes(const HoleLoad& load) {
  return load.edges * kFilledEdgeBytes + load.loops * kFilledLoopBytes;
}

/// With as little beside the boundary as does.
std::uint64_t least_hole_bytes(const Partition& partition, const HoleLoad& load) {
  return whole_cloud_bytes(partition) +
         std::max(traced_bytes(load), filled_bytes(load) + load.chunk_bytes + load.batch_bytes);
}

void require_memory(const ResolvedJob& job, const HoleLoad& load, std::uint64_t needed) {
  const std::uint64_t budget = job.partition.memory_bytes;
  if (needed <= budget || load.edges == 0) return;
  const std::string more = "larger ball radii leave fewer holes";
  const bool fills = job.fill.enabled;
  throw_resource(
      fills ? "the memory budget is too small for the boundary whose holes are to be "
              "filled"
            : "the memory budget is too small for the boundary of the mesh",
      {.file = {},
       .place = setting_name(job, "partition.memory"),
       .found = format_bytes(budget) + "; " + format_count(load.edges) + " boundary edges in " +
                format_count(load.loops) + " loops",
       .expected = "at least " + std::to_string((needed >> 20) + 1) + " MiB",
       .advice = fills ? "Or " + setting(job, "fill.enabled", "false") + "; " + more : more});
}

}  // namespace

std::uint64_t predicted_hole_bytes(const ResolvedJob& job, const Partition& partition,
                                   const HoleLoad& load) {
  const MemoryPlan plan = job.memory_plan(partition.octree.points(), partition.schema);
  const auto threads = static_cast<std::uint64_t>(job.threads());
  const std::uint64_t half = plan.chunks_in_flight_bytes / 2;
  // Those that are kept, and one in use that no longer is.
  const std::uint64_t chunks = load.chunk_bytes + std::min(half, load.all_chunk_bytes);
  const std::uint64_t batches = std::min(half, threads * load.batch_bytes) + load.patch_bytes -
                                std::min(load.patch_bytes, load.batch_bytes);
  const std::uint64_t peak = whole_cloud_bytes(partition) +
                             std::max(traced_bytes(load), filled_bytes(load) + chunks + batches);
  return std::min(peak, std::max(job.partition.memory_bytes, least_hole_bytes(partition, load)));
}

void require_memory_for_holes(const ResolvedJob& job, const Partition& partition,
                              const HoleLoad& load) {
  require_memory(job, load, least_hole_bytes(partition, load));
}

std::uint64_t boundary_bytes(const ResolvedJob& job, const Partition& partition,
                             const HoleLoad& load) {
  if (job.fill.enabled) return least_hole_bytes(partition, load);
  return whole_cloud_bytes(partition) + load.edges * kCountedEdgeBytes + load.pieces * kPieceBytes;
}

void require_memory_for_boundary(const ResolvedJob& job, const Partition& partition,
                                 const HoleLoad& load) {
  require_memory(job, load, boundary_bytes(job, partition, load));
}

void require_memory_for_largest(const ResolvedJob& job, const Partition& partition,
                                std::span<const std::uint64_t> points,
                                std::span<const double> radii) {
  const auto largest = std::max_element(points.begin(), points.end());
  if (largest == points.end()) return;
  if (*largest <= most_points_with_halo(job)) return;
  const std::uint64_t needed = kWorkingBytes + *largest * MemoryCosts::kUsualReconstructBytes;
  const std::uint64_t budget = job.partition.memory_bytes;
  const auto chunk = static_cast<ChunkId>(largest - points.begin());
  throw_resource(
      "the memory budget is too small for the points within the reach of a ball",
      {.file = {},
       .place = setting_name(job, "partition.memory"),
       .found = format_bytes(budget) + "; around chunk " + std::to_string(chunk) + " with its " +
                format_count(partition.points_in(chunk)) + " points, " + format_count(*largest) +
                " lie within the halo of " + format_number(halo_width(radii)),
       .expected = "at least " + std::to_string((needed >> 20) + 1) + " MiB",
       .advice =
           std::string("Or smaller ball radii, which the dense part of the cloud asks for, or ") +
           setting_name(job, "cleaning.thin_to_spacing")});
}

std::string objection_to_peak(const Job& job, std::uint64_t predicted_bytes,
                              std::optional<std::uint64_t> limit_bytes) {
  if (!limit_bytes || predicted_bytes <= *limit_bytes) return {};
  return "the job takes about " + format_bytes(predicted_bytes) +
         " of memory, and the system lets it have " + format_bytes(*limit_bytes) +
         " (the machine's memory, or the limit of a container or a batch system): a job that takes "
         "more may be killed; make " +
         setting_name(job, "partition.memory") + " less than that";
}

}  // namespace orbweave
