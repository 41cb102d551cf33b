// The reconstruction methods that take the whole cloud at once: the Voronoi family.
#pragma once

#include <span>
#include <vector>

#include "engine/ball_pivoting/pivoting_result.h"
#include "engine/pipeline/stage/stage_runner.h"
#include "engine/voronoi/power_crust.h"
#include "engine/voronoi/share_done.h"
#include "engine/voronoi/undersampling.h"
#include "io/job/job.h"
#include "io/stop_token.h"
#include "io/vec3.h"

namespace orbweave {

/// Whether the program was built with the Voronoi family, and hence is under the GPL.
bool has_voronoi_family();

/// Throws Error (usage) where it was not.
void require_voronoi_family();

/// Throws Error (usage) where the program was built without the job's method.
void require_method(const Job& job);

/// The surface of points in canonical order, turned to the side of their normals, by any method but
/// the Power Crust, whose vertices are not the points. Edges have at most two triangles. Throws as
/// the method does, and as require_method.
BallPivotingResult reconstruct_in_core(const Job& job, std::span<const Vec3> positions,
                                       std::span<const Vec3> normals, const StopToken* stop,
                                       const voronoi::ShareDone& done = {});

/// Shows the share of the only chunk that is done as that of its points, in a stage that counts
/// points; the last point is shown when the chunk is stored.
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
