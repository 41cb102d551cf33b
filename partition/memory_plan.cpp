#include "partition/memory_plan.h"

#include <algorithm>
#include <string>

#include "io/error.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kLeastChunkPoints = 20'000;
/// Larger chunks gain nothing where halos are narrow: they are a percent or two already.
constexpr std::uint64_t kMostChunkPoints = 1'000'000;
/// Three corners of two triangles for each point are numbered with 32 bits, with room for more than
/// two.
constexpr std::uint64_t kMostGivenPoints = std::uint64_t{1} << 28;
/// The same where several radii make halos wide.
constexpr std::uint64_t kMostWithWideHalos = 4'000'000;
/// What the smallest chunks and their bins take of points that are small.
constexpr std::size_t kLeastSpent = std::size_t{80} << 20;
/// Allocators and transient copies; the rest is spent.
constexpr double kSpendable = 0.8;

std::size_t held_bytes(const PointSchema& schema) {
  return sizeof(Vec3) + schema.attribute_bytes() + (schema.has_normals ? sizeof(Vec3) : 0);
}

/// At the peak of all stages.
std::size_t point_bytes(const PointSchema& schema) {
  return std::max(MemoryCosts::kReconstructBytes, MemoryCosts::sort_bytes(schema));
}

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string((bytes + (std::uint64_t{1} << 20) - 1) >> 20) + " MiB";
}

void require_least(std::uint64_t budget_bytes, const PointSchema& schema, int threads) {
  const std::uint64_t least = least_budget_bytes(schema, threads);
  if (budget_bytes >= least) return;
  throw_resource("the memory budget is too small",
                 {.file = {},
                  .place = "partition.memory",
                  .found = std::to_string(budget_bytes >> 20) + " MiB",
                  .expected = "at least " + mebibytes(least) + " for " + std::to_string(threads) +
                              (threads == 1 ? " thread" : " threads") + " and points of " +
                              std::to_string(held_bytes(schema)) + " bytes",
                  .advice = threads > 1 ? "Fewer threads take less" : ""});
}

}  // namespace

std::size_t MemoryCosts::sort_bytes(const PointSchema& schema) {
  return 3 * (held_bytes(schema) + sizeof(Vec3)) + 40;
}

std::size_t MemoryCosts::stream_bytes(const PointSchema& schema, int threads) {
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;  // as in StreamOptions
  const auto batches = static_cast<std::size_t>(std::max(threads, 1)) + 2;
  return batches * kBatchPoints * (held_bytes(schema) + sizeof(std::uint32_t));
}

std::uint64_t least_budget_bytes(const PointSchema& schema, int threads) {
  // Sorting gets half of what is spent.
  const std::size_t chunk = kLeastChunkPoints * std::max(MemoryCosts::kReconstructBytes,
                                                         2 * MemoryCosts::sort_bytes(schema));
  const auto spent = static_cast<std::uint64_t>(static_cast<double>(chunk) / kSpendable);
  return MemoryCosts::kBaseBytes + MemoryCosts::stream_bytes(schema, threads) +
         std::max<std::uint64_t>(kLeastSpent, spent);
}

MemoryPlan plan_memory(std::uint64_t budget_bytes, std::uint64_t points, int threads,
                       std::uint64_t wanted_chunk_points, const PointSchema& schema,
                       std::uint64_t worthwhile_points) {
  require_least(budget_bytes, schema, threads);
  const std::size_t base = MemoryCosts::kBaseBytes + MemoryCosts::stream_bytes(schema, threads);
  const auto spendable =
      static_cast<std::size_t>(kSpendable * static_cast<double>(budget_bytes - base));
  const std::size_t per_point = point_bytes(schema);
  MemoryPlan plan;
  plan.chunks_in_flight_bytes = spendable;
  plan.bin_buffer_bytes = spendable / 2;
  if (wanted_chunk_points != 0) {
    const std::uint64_t most = std::min(spendable / MemoryCosts::kReconstructBytes,
                                        spendable / 2 / MemoryCosts::sort_bytes(schema));
    plan.chunk_points = std::min({wanted_chunk_points, most, kMostGivenPoints});
    return plan;
  }
  const auto workers = static_cast<std::size_t>(std::max(threads, 1));
  // A margin for halos and for points that gather in few cells.
  const std::uint64_t affordable = spendable / (per_point * workers) * 4 / 5;
  // Enough chunks that the workers end together, unless the halos cost more than waiting does.
  const std::uint64_t balanced =
      std::max(points / (4 * workers) + 1, std::min(worthwhile_points, points));
  const std::uint64_t most = std::clamp(worthwhile_points, kMostChunkPoints, kMostWithWideHalos);
  plan.chunk_points = std::clamp(std::min(affordable, balanced), kLeastChunkPoints, most);
  return plan;
}

}  // namespace orbweave
