// `inspect --undersampled`: where a cloud is sampled too sparsely to tell its surface.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "engine/voronoi/undersampling.h"
#include "io/job/job.h"
#include "io/point_cloud.h"

namespace orbweave {

/// Throws Error (usage) where the program was built without the Voronoi family, and (resource)
/// where so many points do not fit into the job's memory budget.
void require_undersampling(const Job& job, std::uint64_t points);

/// Points that are not finite, and all but one of those at one place, are left out.
voronoi::Undersampling undersampling_of(PointCloud cloud);

nlohmann::ordered_json undersampled_json(const voronoi::Undersampling& found);
/// A line, and a table of the largest places.
std::string undersampled_text(const voronoi::Undersampling& found);

}  // namespace orbweave
