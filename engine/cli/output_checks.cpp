#include "engine/cli/output_checks.h"

#include <filesystem>

#include "engine/cli/file_kind.h"
#include "io/error.h"

namespace orbweave {

void check_mesh_name(const std::string& mesh) {
  if (mesh != "-" && !is_mesh_format(mesh))
    throw_usage("nobody writes meshes of this name",
                {.file = mesh, .expected = "a name that ends in .ply, .ply.gz, .obj or .stl"});
}

void check_input_is_kept(const std::string& file, const std::vector<std::string>& outputs,
                         const std::string& input) {
  for (const std::string& out : outputs) {
    std::error_code ignored;
    if (out.empty() || out == "-" || !std::filesystem::equivalent(out, file, ignored)) continue;
    throw_usage("the output would replace " + input,
                {.file = out, .advice = "Choose another name for the output."});
  }
}

void check_folder_of(const std::string& output) {
  const std::filesystem::path folder = std::filesystem::path(output).parent_path();
  std::error_code ignored;
  if (folder.empty() || std::filesystem::is_directory(folder, ignored)) return;
  throw_resource("cannot be written there", {.file = output,
                                             .found = folder.string() + ", which is no directory",
                                             .advice = "Create it or choose another place."});
}

}  // namespace orbweave
