#include "engine/holes/implicit_fill.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/holes/patch_values.h"
#include "engine/holes/rim.h"
#include "engine/holes/smooth_disc.h"
#include "engine/holes/surface_sites.h"
#include "engine/holes/zero_set.h"

namespace orbweave {
namespace {

HolePatch finished(const HoleProblem& problem, const Rim& rim, const PatchMesh& disc) {
  HolePatch patch = patch_of_disc(problem, rim, disc);
  patch.method = FillMethod::kImplicit;
  return patch;
}

HolePatch none_because(std::string reason) {
  HolePatch patch;
  patch.reason = std::move(reason);
  return patch;
}

}  // namespace

HolePatch implicit_fill(const HoleProblem& problem, const PatchOptions& options) {
  if (problem.loop.size() < 3) return none_because("fewer than three edges");
  const Rim rim = find_rim(problem);
  const std::optional<PatchMesh> plate = smooth_disc(problem, rim, 2, options);
  if (!plate) return none_because(too_many_points(options));
  const std::vector<std::uint32_t> sites = choose_sites(problem, rim, options.max_sites / 3);
  const SignedDistances distances = signed_distances(problem, rim, sites);
  std::string fault;
  for (const RbfKernel kernel : {RbfKernel::kTriharmonic, RbfKernel::kBiharmonic}) {
    ZeroSetPatch zero = patch_on_zero_set(problem, rim, distances, kernel, *plate, options);
    if (zero.patch) {
      zero.patch->values = values_from_sites(problem, sites, zero.patch->positions, options);
      return std::move(*zero.patch);
    }
    fault = std::move(zero.fault);
  }
  HolePatch patch = finished(problem, rim, *plate);
  patch.reason = "thin plate: " + fault;
  if (!sites.empty()) patch.values = values_from_sites(problem, sites, patch.positions, options);
  return patch;
}

HolePatch membrane_fill(const HoleProblem& problem, const PatchOptions& options) {
  if (problem.loop.size() < 3) return none_because("fewer than three edges");
  const Rim rim = find_rim(problem);
  const std::optional<PatchMesh> disc = smooth_disc(problem, rim, 1, options);
  if (!disc) return none_because(too_many_points(options));
  HolePatch patch = finished(problem, rim, *disc);
  patch.method = FillMethod::kDirect;
  patch.values = values_from_corners(problem, patch.positions);
  return patch;
}

}  // namespace orbweave
