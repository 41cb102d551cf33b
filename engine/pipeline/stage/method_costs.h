// What the reconstruction methods cost that work on the whole cloud at once.
#pragma once

#include <cstdint>
#include <string>

#include "io/job/job.h"

namespace orbweave {

/// Measured on the 100,250-point dragon (docs/study.md), with a margin.
struct MethodCosts {
  std::uint64_t bytes_per_point = 0;
  double microseconds_per_point = 0.0;  ///< of one thread
  double vertices_per_point = 1.0;      ///< of the surface
};

/// Zeros for ball pivoting, whose costs are those of its stage.
MethodCosts costs_of(ReconstructionMethod method);

/// Whether the method takes the whole cloud, in one chunk.
inline bool is_in_core(ReconstructionMethod method) {
  return method != ReconstructionMethod::kBallPivoting;
}

/// Whether the vertices of the method's surface are not the points.
inline bool has_own_vertices(ReconstructionMethod method) {
  return method == ReconstructionMethod::kPowerCrust;
}

/// The name of the job's method, as job files have it.
std::string method_name(const Job& job);

/// Throws Error (resource) where the method takes more than the job's budget for so many points,
/// and says how much it takes.
void require_memory_for_method(const Job& job, std::uint64_t points);

}  // namespace orbweave
