// Which axis of a scan's coordinates is upright, for pictures.
#pragma once

#include <span>
#include <string>

#include "io/job/job.h"

namespace orbweave {

/// The axis that scans imply, by their names and their coordinate system (empty: none). kZ where
/// they have a coordinate system or come in a format of surveying (LAS, LAZ, E57, PTX), whose
/// heights are in z; kAuto where nothing is implied.
UpAxis up_axis_of_scans(std::span<const std::string> files, const std::string& coordinate_system);

/// Whether the scanners of a job stood at places near the points, or its closed surfaces are to
/// face inward: the mesh may be of an interior. `files`: the job's scans, patterns expanded.
bool may_be_interior(const Job& job, std::span<const std::string> files);

/// The axis of a job's picture, in this order: output.picture_up; the axis nearest to normals.up,
/// where that points along it; kZ where normals or the ground are turned to the side of z; what the
/// scans imply, kZ also where scanners have places; kY where poses come from a Stanford .conf,
/// whose objects stand in y. kAuto: the shape decides (io/report/picture.h). `files`: the job's
/// scans, patterns expanded.
UpAxis picture_up(const Job& job, std::span<const std::string> files,
                  const std::string& coordinate_system);

}  // namespace orbweave
