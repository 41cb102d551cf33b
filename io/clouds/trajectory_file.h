// Reads the path of a scanner that moved.
#pragma once

#include <cstddef>
#include <filesystem>

#include "io/clouds/trajectory.h"
#include "io/stop_token.h"
#include "io/streams/byte_reader.h"

namespace orbweave {

/// Most places of a path that are kept, evenly spread over the file: 3 MiB. At 200 places a second
/// a flight of two hours has one in 15 of them, 13 a second.
inline constexpr std::size_t kMostTrajectoryPlaces = 100'000;

/// Reads a trajectory. LAS, LAZ, PLY, PCD and E57: points with a time (find_time()). Everything
/// else is text, maybe with ".gz": columns that a header line, or a comment in its place, names as
/// time (or timestamp, gps_time, t, seconds), x (tx, easting), y (ty, northing) and z (tz, height,
/// altitude, up), or else the first four, in this order; other columns are passed over. Throws
/// Error (bad input) with file and line.
Trajectory read_trajectory(const std::filesystem::path& path, const StopToken* stop = nullptr);
/// Reads a trajectory from text. Throws as read_trajectory().
Trajectory read_trajectory_text(ByteReader reader);

}  // namespace orbweave
