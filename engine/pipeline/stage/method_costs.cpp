#include "engine/pipeline/stage/method_costs.h"

#include <algorithm>
#include <variant>

#include "io/error.h"
#include "io/job/job_keys.h"
#include "io/job/setting.h"
#include "io/text/quantity.h"
#include "partition/memory_plan.h"

namespace orbweave {

MethodCosts costs_of(ReconstructionMethod method) {
  switch (method) {
    case ReconstructionMethod::kBallPivoting:
      return {};
    case ReconstructionMethod::kCrust:
      return {2600, 20.0};
    case ReconstructionMethod::kPowerCrust:
      return {3200, 54.0, 9.5};
    case ReconstructionMethod::kCocone:
    case ReconstructionMethod::kSuperCocone:
    case ReconstructionMethod::kTightCocone:
      return {1100, 9.5};
  }
  return {};
}

MethodCosts costs_of(NormalSource source) {
  return source == NormalSource::kPoles ? MethodCosts{1000, 6.0} : MethodCosts{};
}

std::string method_name(const Job& job) {
  for (const JobKey& key : job_keys())
    if (key.name() == "reconstruct.method") return std::get<std::string>(key.get(job));
  return {};
}

namespace {

/// `what` holds the whole cloud; `instead`: what does not.
void require_memory(const Job& job, std::uint64_t points, std::uint64_t per_point,
                    const std::string& what, const std::string& instead) {
  const std::uint64_t needed = MemoryCosts::kBaseBytes + points * per_point;
  const std::uint64_t budget = job.partition.memory_bytes;
  if (per_point == 0 || needed <= budget) return;
  throw_resource("the memory budget is too small for " + what + ", which holds the whole cloud",
                 {.file = {},
                  .place = setting_name(job, "partition.memory"),
                  .found = format_bytes(budget) + "; " + format_count(points) + " points of some " +
                           std::to_string(per_point) + " bytes",
                  .expected = "at least " + std::to_string((needed >> 20) + 1) + " MiB",
                  .advice = "Or " + instead});
}

}  // namespace

bool goes_in_chunks(const Job& job, std::uint64_t points) {
  if (job.reconstruct.method != ReconstructionMethod::kCocone)
    return job.reconstruct.method == ReconstructionMethod::kSuperCocone;
  const std::uint64_t per_point = costs_of(job.reconstruct.method).bytes_per_point;
  return MemoryCosts::kBaseBytes + points * per_point > job.partition.memory_bytes;
}

bool is_super_cocone(const Job& job, const Partition& partition) {
  return is_cocone(job.reconstruct.method) && partition.octree.chunks().size() > 1;
}

std::uint64_t super_cocone_chunk_points(const Job& job) {
  constexpr std::uint64_t kLeastPoints = 10'000;
  constexpr double kSpendable = 0.8;
  constexpr double kUneven = 1.3;  // surfaces do not fill a box alike
  const std::uint64_t budget = job.partition.memory_bytes;
  const std::uint64_t per_point = costs_of(job.reconstruct.method).bytes_per_point;
  const double room =
      kSpendable * static_cast<double>(budget - std::min(budget, MemoryCosts::kBaseBytes));
  const auto most = static_cast<std::uint64_t>(
      room / (kGrownCoconeBox * kUneven * static_cast<double>(per_point)));
  if (most < kLeastPoints)
    throw_resource("the memory budget is too small for " + method_name(job) + " in chunks",
                   {.place = setting_name(job, "partition.memory"),
                    .found = format_bytes(budget) + ", room for chunks of " + format_count(most) +
                             " points with what lies around them",
                    .expected = "room for " + format_count(kLeastPoints) + " points"});
  return job.partition.chunk_points == 0 ? most : std::min(job.partition.chunk_points, most);
}

void require_memory_for_method(const Job& job, std::uint64_t points) {
  if (goes_in_chunks(job, points)) return;
  require_memory(job, points, costs_of(job.reconstruct.method).bytes_per_point,
                 "the method " + method_name(job),
                 setting(job, "reconstruct.method", "ball_pivoting") + ", or " +
                     setting_name(job, "cleaning.thin_to_spacing"));
}

void require_memory_for_poles(const Job& job, std::uint64_t points) {
  require_memory(job, points, costs_of(job.normals.source).bytes_per_point,
                 setting(job, "normals.source", "poles"),
                 setting(job, "normals.source", "estimate") + ", which goes chunk by chunk");
}

}  // namespace orbweave
