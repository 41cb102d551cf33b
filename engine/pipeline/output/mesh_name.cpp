#include "engine/pipeline/output/mesh_name.h"

#include <optional>
#include <string>

#include "io/error.h"
#include "io/meshes/file_with_places.h"
#include "io/meshes/heavy_data.h"
#include "io/text/file_format.h"

namespace orbweave {
namespace {

bool writes_mesh_of_name(const std::string& name) {
  const std::optional<NamedFormat> named = format_of_name(name);
  return named && named->facts.writes_mesh && (!named->is_gzipped || named->facts.writes_gzip);
}

}  // namespace

void check_mesh_name(const OutputOptions& output) {
  const std::string& mesh = output.mesh;
  if (mesh != "-" && !writes_mesh_of_name(mesh))
    throw_usage("cannot write " + files_of_name(mesh, "meshes") +
                    "; supported: " + extensions_of_written_meshes(),
                {.file = mesh});
  const std::optional<NamedFormat> named = format_of_name(mesh);
  if (output.requires_binary && named && named->facts.format == FileFormat::kObj)
    throw_usage("OBJ has no binary encoding",
                {.file = mesh,
                 .found = "output.format = \"binary\"",
                 .expected = "\"auto\" or \"text\", or a .ply or .stl file"});
  if (!output.binary && named && has_no_text(named->facts.format))
    throw_usage(spoken_name(named->facts) + " has no text encoding",
                {.file = mesh,
                 .found = "output.format = \"text\"",
                 .expected = "\"auto\" or \"binary\", or a .ply, .obj or .stl file"});
  check_heavy_data(mesh);
  check_file_with_places(mesh);
}

}  // namespace orbweave
