#include "partition/memory_plan.h"

#include <algorithm>
#include <string>

#include "io/error.h"

namespace orbweave {
namespace {

constexpr std::uint64_t kLeastChunkPoints = 20'000;
/// Larger chunks gain nothing: their halo is already a percent or two.
constexpr std::uint64_t kMostChunkPoints = 1'000'000;
constexpr std::size_t kLeastBudget = MemoryCosts::kBaseBytes + (std::size_t{80} << 20);
/// Allocators and transient copies; the rest is spent.
constexpr double kSpendable = 0.8;

}  // namespace

std::size_t MemoryCosts::sort_bytes(const PointSchema& schema) {
  const std::size_t record =
      2 * sizeof(Vec3) + schema.attribute_bytes() + (schema.has_normals ? sizeof(Vec3) : 0);
  return 3 * record + 40;
}

MemoryPlan plan_memory(std::uint64_t budget_bytes, std::uint64_t points, int threads,
                       std::uint64_t wanted_chunk_points, const PointSchema& schema,
                       std::uint64_t worthwhile_points) {
  if (budget_bytes < kLeastBudget) {
    throw_resource("the memory budget is too small",
                   {.file = {},
                    .place = "partition.memory",
                    .found = std::to_string(budget_bytes >> 20) + " MiB",
                    .expected = "at least " + std::to_string(kLeastBudget >> 20) + " MiB",
                    .advice = {}});
  }
  const auto spendable = static_cast<std::size_t>(
      kSpendable * static_cast<double>(budget_bytes - MemoryCosts::kBaseBytes));
  MemoryPlan plan;
  plan.chunks_in_flight_bytes = spendable;
  plan.bin_buffer_bytes = spendable / 2;
  if (wanted_chunk_points != 0) {
    plan.chunk_points = wanted_chunk_points;
    return plan;
  }
  const std::size_t per_point =
      std::max(MemoryCosts::kReconstructBytes, MemoryCosts::sort_bytes(schema));
  const auto workers = static_cast<std::size_t>(std::max(threads, 1));
  // A margin for halos and for points that gather in few cells.
  const std::uint64_t affordable = spendable / (per_point * workers) * 4 / 5;
  // Enough chunks that the workers end together.
  const std::uint64_t balanced = std::max(points / (4 * workers) + 1, worthwhile_points);
  plan.chunk_points =
      std::clamp(std::min(affordable, balanced), kLeastChunkPoints, kMostChunkPoints);
  return plan;
}

}  // namespace orbweave
