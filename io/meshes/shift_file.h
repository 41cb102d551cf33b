// The shift of a file's coordinates, beside it: its name and .shift.txt, so that m.ply and m.stl
// have one each.
#pragma once

#include <filesystem>
#include <string>

#include "io/point_cloud.h"
#include "io/vec3.h"

namespace orbweave {

/// Where the shift of a file goes; empty: a stream or a device has no place beside it, and a GLB
/// file holds its origin itself.
std::filesystem::path shift_file(const std::filesystem::path& file);

/// Whether a name is that of the shift of some file.
bool is_name_of_shift(const std::filesystem::path& file);

/// Writes "name; x; y; z; scale;" as CloudCompare's list of global shifts has it: coordinates of
/// the file are those of the world plus x, y, z, which are the origin's negative. Without an origin
/// nothing is written, but that the shift of an earlier mesh of that name becomes 0. Returns the
/// file; empty: none is written.
std::filesystem::path write_shift(const std::filesystem::path& file, Vec3 origin);

/// The origin that the coordinates of a file are counted from, by the shift beside it or, of a tile
/// among the others of its mesh, by their index (tile_directory.h); zero: none. Of a list of
/// several shifts, that of the file's name. Throws Error (bad input) where the file beside it is no
/// such list or cannot be opened, and where its lines contradict each other.
Vec3 origin_beside(const std::filesystem::path& file);
/// The origin in the words of the header of a PLY file, compressed or not; empty: it names none, or
/// the file is no PLY or cannot be read.
std::string origin_in_header(const std::filesystem::path& file);
/// Points as the world has them, of points counted from an origin.
void add_origin(Vec3 origin, PointCloud& points);

}  // namespace orbweave
