// What a command finds out about its outputs before it works rather than after.
#pragma once

#include <string>
#include <vector>

namespace orbweave {

/// Throws Error (usage) where nobody writes meshes of this name.
void check_mesh_name(const std::string& mesh);
/// Throws Error (usage) where one of the outputs is the input's file; empty names and "-" are
/// passed over. `input` says what it is: "a scan of the job".
void check_input_is_kept(const std::string& file, const std::vector<std::string>& outputs,
                         const std::string& input);
/// Throws Error (resource) where the output's folder is none.
void check_folder_of(const std::string& output);

}  // namespace orbweave
