#include "engine/pipeline/stage/method_costs.h"

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
      return {2600, 30.0};
    case ReconstructionMethod::kPowerCrust:
      return {3200, 56.0, 9.5};
    case ReconstructionMethod::kCocone:
    case ReconstructionMethod::kTightCocone:
      return {1100, 12.0};
  }
  return {};
}

std::string method_name(const Job& job) {
  for (const JobKey& key : job_keys())
    if (key.name() == "reconstruct.method") return std::get<std::string>(key.get(job));
  return {};
}

void require_memory_for_method(const Job& job, std::uint64_t points) {
  const std::uint64_t per_point = costs_of(job.reconstruct.method).bytes_per_point;
  if (per_point == 0) return;
  const std::uint64_t needed = MemoryCosts::kBaseBytes + points * per_point;
  const std::uint64_t budget = job.partition.memory_bytes;
  if (needed <= budget) return;
  throw_resource("the memory budget is too small for the method " + method_name(job) +
                     ", which holds the whole cloud",
                 {.file = {},
                  .place = setting_name(job, "partition.memory"),
                  .found = format_bytes(budget) + "; " + format_count(points) + " points of some " +
                           std::to_string(per_point) + " bytes",
                  .expected = "at least " + std::to_string((needed >> 20) + 1) + " MiB",
                  .advice = "Or " + setting(job, "reconstruct.method", "ball_pivoting") + ", or " +
                            setting_name(job, "cleaning.thin_to_spacing")});
}

}  // namespace orbweave
