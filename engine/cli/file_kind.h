// What a file is, by its name (io/text/file_format.h) and, where that leaves it open, by its
// header.
#pragma once

#include <string>

namespace orbweave {

bool is_mesh_file(const std::string& name);          ///< holds faces; reads the header
bool is_mesh_only_format(const std::string& name);   ///< holds faces and is not written as a cloud
bool is_cloud_only_format(const std::string& name);  ///< never holds faces
bool is_scan_format(const std::string& name);        ///< is read as a cloud

}  // namespace orbweave
