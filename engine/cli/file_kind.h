// What a file is, by its name and, where that leaves it open, by its header.
#pragma once

#include <string>

namespace orbweave {

bool is_mesh_file(const std::string& name);          ///< holds faces; reads the header
bool is_mesh_format(const std::string& name);        ///< .ply (also .gz), .obj, .stl
bool is_mesh_only_format(const std::string& name);   ///< .obj, .stl
bool is_cloud_only_format(const std::string& name);  ///< .xyz .txt .csv .pts, each also with .gz

}  // namespace orbweave
