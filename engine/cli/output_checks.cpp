#include "engine/cli/output_checks.h"

#include "io/meshes/heavy_data.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system_file.h"

namespace orbweave {

std::vector<PathRole> files_of_mesh(const std::string& mesh) {
  return {{"the mesh", mesh, PathUse::kWrittenFile},
          {"the numbers of the mesh", heavy_data_file(mesh), PathUse::kWrittenFile},
          {"the coordinate system beside the mesh", coordinate_system_file(mesh),
           PathUse::kWrittenFile, false, false},
          {"the shift of coordinates beside the mesh", shift_file(mesh), PathUse::kWrittenFile,
           false, false}};
}

}  // namespace orbweave
