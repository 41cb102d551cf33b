#include "engine/cli/files_beside.h"

#include <filesystem>
#include <system_error>

#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system_file.h"
#include "io/shown_text.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

void write_system(const std::string& file, const std::string& in, const std::string& system) {
  const fs::path written = write_coordinate_system(file, system);
  if (!written.empty()) note_written(written.string());
  const std::string problem = written_system(system).problem;
  if (!problem.empty())
    print_warning("the coordinate system of " + in + ", " + shown(system) + ": " + problem);
  const fs::path beside = coordinate_system_file(file);
  std::error_code ignored;
  if (!written.empty() || beside.empty() || !fs::exists(beside, ignored)) return;
  print_warning(beside.string() + " was there before and is taken for the coordinate system of " +
                file + "; " + in + (system.empty() ? " tells of none" : " tells of another") +
                ". Remove it if an earlier command has left it");
}

}  // namespace

void write_files_beside(const std::string& file, const std::string& in, const std::string& system,
                        Vec3 origin) {
  const fs::path shift = write_shift(file, origin);
  if (!shift.empty()) note_written(shift.string());
  write_system(file, in, system);
}

}  // namespace orbweave
