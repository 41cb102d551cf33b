// What the file of a mesh or a cloud does not hold: coordinate system and shift of the coordinates,
// which lie beside it, and attributes without a place.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "io/point_cloud.h"
#include "io/triangle_mesh.h"
#include "io/vec3.h"

namespace orbweave {

/// Writes both where there is anything to write. Warns of a system that PROJ does not know, and of
/// a .prj of that name that was there before and says nothing about this file. `in`: the file that
/// was read, as the warnings name it.
void write_files_beside(const std::string& file, const std::string& in, const std::string& system,
                        Vec3 origin);

/// Warns of each PLY file whose header says that its coordinates are counted from an origin, with
/// no shift beside it that says the same to a reader: it was renamed or moved alone.
void warn_of_lost_origins(std::span<const std::string> files);

/// Warns of each .prj beside a file whose words stand for no system that is known.
void warn_of_unknown_systems(std::span<const std::string> files);

/// Warns where the coordinates of two files are of different systems, so that distances between
/// them tell nothing. A system that is not known fits any.
void warn_of_two_systems(const std::string& file, const std::string& system,
                         const std::string& other_file, const std::string& other_system);

/// What a file holds beside what was read of it, as a warning; empty where it holds nothing else.
std::string left_out_of_input(const std::string& file, const std::vector<std::string>& left_out);
/// Prints it, where there is any.
void warn_of_left_out(const std::string& file, const std::vector<std::string>& left_out);

/// Does the work. What is wrong with all that a file holds names no file: bad input gets it then.
void name_in_errors(const std::string& file, const std::function<void()>& work);

/// Whether a face of the mesh fills a hole.
bool fills_holes(const TriangleMesh& mesh);

/// What the vertices of a mesh carry and the format of its file does not hold, in words; empty: it
/// holds everything. `patches`: likewise of faces that fill holes (patches_without_place()).
std::string left_out_of(const std::string& file, const PointSchema& schema,
                        const std::vector<std::string>& patches = {});

}  // namespace orbweave
