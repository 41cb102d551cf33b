// What a PLY file holds beside what is read of it.
#pragma once

#include <string>
#include <vector>

#include "io/ply/ply_header.h"

namespace orbweave {

/// Lists of vertices, in words ("vertex list colours"). Names are as in the header.
std::vector<std::string> lost_values_of_ply(const PlyHeader& header);

/// Elements with rows that are not read, in words ("element edge of 5 rows"); of a mesh also lists
/// of vertices and the properties of faces that triangles have no place for.
std::vector<std::string> left_out_of_ply(const PlyHeader& header, bool is_mesh);

/// Of faces that are no surface: none, or "2 faces with fewer than three corners".
std::vector<std::string> left_out_faces(std::uint64_t faces);

}  // namespace orbweave
