// The reconstruction methods that take the whole cloud at once: the Voronoi family.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/ball_pivoting/pivoting_result.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/voronoi/power_crust.h"
#include "engine/voronoi/share_done.h"
#include "engine/voronoi/undersampling.h"
#include "io/box.h"
#include "io/job/job.h"
#include "io/stop_token.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// Whether the program was built with the Voronoi family, and hence is under the GPL.
bool has_voronoi_family();

/// Throws Error (usage) where it was not.
void require_voronoi_family();

/// Throws Error (usage) where the program was built without the job's method or source of normals.
void require_method(const Job& job);

/// Unit vectors from the points to their poles, of either sign. Throws Error (bad input) where the
/// points lie in one plane, and as require_voronoi_family.
std::vector<Vec3> normals_from_poles(const Job& job, std::span<const Vec3> positions,
                                     const StopToken* stop);

/// What a method finds of points that it has all at once.
struct InCoreSurface {
  BallPivotingResult surface;
  std::vector<std::uint8_t> undersampled;  ///< 1 per point that is; empty: the method does not tell
};

/// The surface of points in canonical order, turned to the side of their normals, by any method but
/// the Power Crust, whose vertices are not the points. Edges have at most two triangles. Throws as
/// the method does, and as require_method.
InCoreSurface reconstruct_in_core(const Job& job, std::span<const Vec3> positions,
                                  std::span<const Vec3> normals, const StopToken* stop,
                                  const voronoi::ShareDone& done = {});

/// The Cocone of a part of a cloud.
struct CoconeOfPart {
  std::vector<Triangle> triangles;         ///< turned to the normals, smallest first, sorted
  std::vector<std::uint8_t> undersampled;  ///< per point
  std::vector<std::uint8_t> certified;     ///< per point: its Voronoi cell is the whole cloud's
};

/// The Cocone of all points of a cloud in the box `known`; `cloud`: around the whole cloud. Points
/// that no tetrahedron can be formed of have no triangles. Throws otherwise as
/// voronoi::cocone_of_part.
CoconeOfPart cocone_of_part(std::span<const Vec3> positions, std::span<const Vec3> normals,
                            const Box& known, const Box& cloud, const StopToken* stop);

/// Shows the share of the only chunk that is done as that of its points, in a stage that counts
/// points; the last point is shown when the chunk is stored. Throws Error (resource) once it is
/// clear that the method needs more memory than the budget: few shapes have more tetrahedra than
/// foreseen, as a torus whose poles lie on a circle, and these many times as many.
voronoi::ShareDone progress_within_chunk(StageRunner& runner, std::uint64_t points);

/// As voronoi::power_crust with the published options; throws Error (usage) where there is no
/// Voronoi family.
voronoi::PowerCrustSurface power_crust_in_core(std::span<const Vec3> positions,
                                               const StopToken* stop,
                                               const voronoi::ShareDone& done);
/// As voronoi::triangles_of.
std::vector<Triangle> triangles_in_core(const voronoi::PowerCrustSurface& surface);

/// Points that are sampled too sparsely for the shape that they lie on. Throws as
/// voronoi::find_undersampling, and Error (usage) where there is no Voronoi family.
voronoi::Undersampling find_undersampling(std::span<const Vec3> positions, const StopToken* stop);

}  // namespace orbweave
