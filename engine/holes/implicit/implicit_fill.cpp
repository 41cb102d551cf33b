#include "engine/holes/implicit/implicit_fill.h"

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/holes/implicit/surface_sites.h"
#include "engine/holes/implicit/zero_set.h"
#include "engine/holes/patch/patch_intersections.h"
#include "engine/holes/patch/patch_values.h"
#include "engine/holes/patch/rim.h"
#include "engine/holes/patch/smooth_disc.h"
#include "engine/holes/rbf/bending_energy.h"

namespace orbweave {
namespace {

HolePatch finished(const HoleProblem& problem, const Rim& rim, const PatchMesh& disc) {
  HolePatch patch = patch_of_disc(problem, rim, disc);
  patch.method = FillMethod::kImplicit;
  return patch;
}

HolePatch none_because(std::string reason, OpenReason open = OpenReason::kOther) {
  HolePatch patch;
  patch.open = open;
  patch.reason = std::move(reason);
  return patch;
}

/// Sites enough for the loop and what is near; more add little to a small hole.
std::uint32_t most_sites(const Rim& rim, const PatchOptions& options) {
  const std::size_t useful = 60 + 2 * rim.corners.size();
  return static_cast<std::uint32_t>(std::min<std::size_t>(useful, options.max_sites / 3));
}

struct Candidate {
  HolePatch patch;
  double energy = std::numeric_limits<double>::infinity();
};

/// The triharmonic zero set carries the curvature around the hole into it and is the better guess
/// (the least error on scans), but from the end of a tube it runs away. Where it bends this much
/// more than a thin plate, the biharmonic one may be fairer.
constexpr double kMostBending = 1.5;

/// Whether the zero set of a signed distance can say more about the patch than the thin plate does.
/// A few points have no room for it; tens of thousands have far more than its sites know of. Where
/// the plate leaves the rim's faces at a steep angle on the mean, the rim is crumpled: the normals
/// along it, and with them the distance, mean nothing. So they do where the rim itself runs into
/// the sheet, or the plate does often: the zero sets of such rims fold or run into it too.
/// Returns how often the plate meets something where a zero set is worth a look, else nothing.
std::optional<std::uint64_t> worth_a_zero_set(const HoleProblem& problem, const Rim& rim,
                                              const PatchMesh& disc, const HolePatch& plate,
                                              const BoxTree& sheet, const RimPiercings& piercings) {
  constexpr std::uint32_t kLeastPoints = 8;
  constexpr std::uint32_t kMostPoints = 20'000;
  constexpr std::uint64_t kFewContacts = 8;
  constexpr std::size_t kTrianglesPerContact = 20;
  constexpr std::size_t kManyTriangles = 400;  // their zero set is most of the work
  constexpr double kCrumpled = std::numbers::pi / 3.0;
  constexpr double kSteep = std::numbers::pi / 4.0;  // of a plate that meets the sheet
  const std::uint32_t points = disc.size() - disc.corners();
  if (points < kLeastPoints || points > kMostPoints) return std::nullopt;
  if (piercings.any()) return std::nullopt;
  const double angle = rim_angles(problem, rim.faces, plate).mean;
  if (!(angle < kCrumpled)) return std::nullopt;
  const std::size_t triangles = plate.triangles.size();
  const std::uint64_t most =
      triangles > kManyTriangles || angle > kSteep
          ? 0
          : std::max<std::uint64_t>(kFewContacts, triangles / kTrianglesPerContact);
  const std::uint64_t contacts = count_intersections(problem, sheet, plate, most + 1);
  return contacts <= most ? std::optional(contacts) : std::nullopt;
}

}  // namespace

HolePatch implicit_fill(const HoleProblem& problem, const LoopTriangles& loop,
                        const PatchOptions& options) {
  const BoxTree sheet = BoxTree::of_sheet(problem.positions, problem.sheet);
  HolePatch patch =
      implicit_fill(problem, loop, sheet, RimPiercings(problem, sheet), options).patch;
  give_values(problem, patch);
  return patch;
}

ImplicitPatch implicit_fill(const HoleProblem& problem, const LoopTriangles& loop,
                            const BoxTree& sheet, const RimPiercings& piercings,
                            const PatchOptions& options) {
  if (problem.loop.size() < 3) return {none_because("fewer than three edges")};
  const Rim& rim = loop.rim;
  std::optional<PatchMesh> disc = smooth_disc(problem, loop, 2, options);
  if (!disc) return {none_because(too_many_points(options), OpenReason::kTooManyPoints)};
  HolePatch plate = finished(problem, rim, *disc);
  const std::optional<std::uint64_t> contacts_of_plate =
      worth_a_zero_set(problem, rim, *disc, plate, sheet, piercings);
  if (!contacts_of_plate) {
    plate.reason = "thin plate";
    plate.lacks_values = true;
    return {std::move(plate)};
  }
  const std::vector<std::uint32_t> sites = choose_sites(problem, rim, most_sites(rim, options));
  const SignedDistances distances = signed_distances(problem, rim, sites);
  const double usual_energy = kMostBending * bending_energy(problem, rim.faces, plate);
  Candidate best;
  std::string fault;
  for (const RbfKernel kernel : {RbfKernel::kTriharmonic, RbfKernel::kBiharmonic}) {
    ZeroSetPatch zero = patch_on_zero_set(problem, rim, distances, kernel, *disc, options);
    if (!zero.patch) {
      fault = std::move(zero.fault);
      continue;
    }
    const double energy = bending_energy(problem, rim.faces, *zero.patch);
    if (energy < best.energy) best = {std::move(*zero.patch), energy};
    if (best.energy <= usual_energy) break;
  }
  const bool is_rough = best.energy > 2.0 * usual_energy;
  bool is_clear = !is_rough && count_intersections(problem, sheet, best.patch, 1) == 0;
  // Where only one of the two is clear of the sheet, it is that one.
  if (is_rough || (!is_clear && contacts_of_plate == 0)) {
    if (fault.empty())
      fault = is_rough ? "the zero set is rough" : "the zero set meets the surface";
    best.patch = std::move(plate);
    best.patch.reason = "thin plate: " + fault;
    is_clear = contacts_of_plate == 0;
  }
  best.patch.values = values_from_sites(problem, sites, best.patch.positions, options);
  return {std::move(best.patch), is_clear};
}

namespace {

/// The membrane, its new vertices moved by `move`.
template <class Move>
HolePatch moved_membrane(const HoleProblem& problem, const LoopTriangles& loop,
                         const PatchOptions& options, const Move& move) {
  if (problem.loop.size() < 3) return none_because("fewer than three edges");
  std::optional<PatchMesh> disc = smooth_disc(problem, loop, 1, options);
  if (!disc) return none_because(too_many_points(options), OpenReason::kTooManyPoints);
  move(*disc);
  HolePatch patch = finished(problem, loop.rim, *disc);
  patch.method = FillMethod::kDirect;
  patch.lacks_values = true;
  return patch;
}

Vec3 on_ground(const RecessedPlane& plane, Vec3 x) {
  return x - (dot(x, plane.axis) - plane.depth) * plane.axis;
}

/// New vertices go to the plane; those beside a corner that stands above it go most of the way to
/// the place below the corner, too: what was not seen between is steep.
void move_to_ground(const RecessedPlane& plane, double spacing, PatchMesh& disc) {
  constexpr double kLeastStep = 0.5;  // edge lengths
  constexpr double kWay = 0.6;
  const std::vector<std::vector<std::uint32_t>> neighbors = disc.neighbors();
  std::vector<Vec3>& at = disc.positions();
  for (std::uint32_t v = disc.corners(); v < disc.size(); ++v) {
    at[v] = on_ground(plane, at[v]);
    Vec3 below;
    std::size_t above = 0;
    for (const std::uint32_t n : neighbors[v]) {
      if (n >= disc.corners() || dot(at[n], plane.axis) < plane.depth + kLeastStep * spacing)
        continue;
      below = below + on_ground(plane, at[n]);
      ++above;
    }
    if (above > 0) at[v] = at[v] + kWay * (below / static_cast<double>(above) - at[v]);
  }
}

}  // namespace

HolePatch membrane_fill(const HoleProblem& problem, const LoopTriangles& loop,
                        const PatchOptions& options) {
  return moved_membrane(problem, loop, options, [](PatchMesh&) {});
}

HolePatch recessed_fill(const HoleProblem& problem, const LoopTriangles& loop,
                        const RecessedPlane& plane, const PatchOptions& options) {
  return moved_membrane(problem, loop, options,
                        [&](PatchMesh& disc) { move_to_ground(plane, loop.rim.spacing, disc); });
}

}  // namespace orbweave
