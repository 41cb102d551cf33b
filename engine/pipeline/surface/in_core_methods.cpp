#include "engine/pipeline/surface/in_core_methods.h"

#include <utility>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/stitching/triangle_fans.h"
#include "io/error.h"
#include "io/job/setting.h"

#ifdef ORBWEAVE_HAS_VORONOI
#include "engine/voronoi/voronoi.h"
#endif

namespace orbweave {
namespace {

#ifdef ORBWEAVE_HAS_VORONOI
std::vector<Triangle> triangles_of(ReconstructionMethod method, std::span<const Vec3> positions,
                                   const StopToken* stop, const voronoi::ShareDone& done) {
  constexpr voronoi::CrustOptions kCrust{.filters = false, .extracts_manifold = true};
  if (method == ReconstructionMethod::kCrust)
    return voronoi::crust(positions, kCrust, stop, done).triangles;
  if (method == ReconstructionMethod::kCocone)
    return voronoi::cocone(positions, {}, stop, done).triangles;
  return voronoi::tight_cocone(positions, stop, done).triangles;
}

voronoi::PowerCrustSurface power_crust_of(std::span<const Vec3> positions, const StopToken* stop,
                                          const voronoi::ShareDone& done) {
  return voronoi::power_crust(positions, {}, stop, done);
}

std::vector<Triangle> triangles_of_crust(const voronoi::PowerCrustSurface& surface) {
  return voronoi::triangles_of(surface);
}

voronoi::Undersampling undersampling_of(std::span<const Vec3> positions, const StopToken* stop) {
  return voronoi::find_undersampling(positions, stop);
}
#else
std::vector<Triangle> triangles_of(ReconstructionMethod, std::span<const Vec3>, const StopToken*,
                                   const voronoi::ShareDone&) {
  return {};
}

voronoi::PowerCrustSurface power_crust_of(std::span<const Vec3>, const StopToken*,
                                          const voronoi::ShareDone&) {
  return {};
}

std::vector<Triangle> triangles_of_crust(const voronoi::PowerCrustSurface&) { return {}; }

voronoi::Undersampling undersampling_of(std::span<const Vec3>, const StopToken*) { return {}; }
#endif

[[noreturn]] void refuse_family(ErrorParts parts) {
  parts.advice = "Install CGAL (libcgal-dev) and build again; the program is under the GPL then";
  throw_usage("this program was built without the methods of the Voronoi family", parts);
}

}  // namespace

bool has_voronoi_family() {
#ifdef ORBWEAVE_HAS_VORONOI
  return true;
#else
  return false;
#endif
}

void require_voronoi_family() {
  if (!has_voronoi_family()) refuse_family({});
}

void require_method(const Job& job) {
  if (!is_in_core(job.reconstruct.method)) return;
  if (!has_voronoi_family())
    refuse_family({.file = {},
                   .place = setting_name(job, "reconstruct.method"),
                   .found = method_name(job),
                   .expected = "ball_pivoting"});
}

BallPivotingResult reconstruct_in_core(const Job& job, std::span<const Vec3> positions,
                                       std::span<const Vec3> normals, const StopToken* stop,
                                       const voronoi::ShareDone& done) {
  require_method(job);
  std::vector<Triangle> triangles = triangles_of(job.reconstruct.method, positions, stop, done);
  turn_to_normals(positions, normals, triangles, stop);
  return with_fans(std::move(triangles), positions.size(), stop);
}

voronoi::ShareDone progress_within_chunk(StageRunner& runner, std::uint64_t points) {
  return [&runner, points, shown = std::uint64_t{0}](double share) mutable {
    const auto reached = static_cast<std::uint64_t>(share * static_cast<double>(points - 1));
    if (reached <= shown) return;
    runner.progress.advance(reached - shown);
    shown = reached;
  };
}

voronoi::PowerCrustSurface power_crust_in_core(std::span<const Vec3> positions,
                                               const StopToken* stop,
                                               const voronoi::ShareDone& done) {
  require_voronoi_family();
  return power_crust_of(positions, stop, done);
}

std::vector<Triangle> triangles_in_core(const voronoi::PowerCrustSurface& surface) {
  return triangles_of_crust(surface);
}

voronoi::Undersampling find_undersampling(std::span<const Vec3> positions, const StopToken* stop) {
  require_voronoi_family();
  return undersampling_of(positions, stop);
}

}  // namespace orbweave
