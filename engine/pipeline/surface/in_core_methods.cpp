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
                                   const StopToken* stop) {
  if (method == ReconstructionMethod::kCrust)
    return voronoi::crust(positions, {.filters = false, .extracts_manifold = true}, stop).triangles;
  if (method == ReconstructionMethod::kCocone)
    return voronoi::cocone(positions, {}, stop).triangles;
  return voronoi::tight_cocone(positions, stop).triangles;
}

voronoi::Undersampling undersampling_of(std::span<const Vec3> positions, const StopToken* stop) {
  return voronoi::find_undersampling(positions, stop);
}
#else
std::vector<Triangle> triangles_of(ReconstructionMethod, std::span<const Vec3>, const StopToken*) {
  return {};
}

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
  const ErrorParts where{
      .file = {}, .place = setting_name(job, "reconstruct.method"), .found = method_name(job)};
  if (!has_voronoi_family()) {
    ErrorParts parts = where;
    parts.expected = "ball_pivoting";
    refuse_family(parts);
  }
  if (job.reconstruct.method == ReconstructionMethod::kPowerCrust) {
    ErrorParts parts = where;
    parts.expected = "ball_pivoting, crust, cocone or tight_cocone";
    parts.advice = "tight_cocone is watertight as well, and its vertices are points";
    throw_usage("the vertices of a Power Crust are not points of the scan, and a job keeps points",
                parts);
  }
}

BallPivotingResult reconstruct_in_core(const Job& job, std::span<const Vec3> positions,
                                       std::span<const Vec3> normals, const StopToken* stop) {
  require_method(job);
  std::vector<Triangle> triangles = triangles_of(job.reconstruct.method, positions, stop);
  turn_to_normals(positions, normals, triangles, stop);
  return with_fans(std::move(triangles), positions.size(), stop);
}

voronoi::Undersampling find_undersampling(std::span<const Vec3> positions, const StopToken* stop) {
  require_voronoi_family();
  return undersampling_of(positions, stop);
}

}  // namespace orbweave
