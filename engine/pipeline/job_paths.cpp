#include "engine/pipeline/job_paths.h"

#include <filesystem>

#include "engine/pipeline/run_steps.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "io/job/selected_points.h"
#include "io/job/setting.h"
#include "io/job/simplified_file.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/shift_file.h"
#include "io/meshes/tile_directory.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/output_names.h"
#include "io/report/report.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

/// Of formats that have them in a file of their own.
void add_numbers(const char* role, const fs::path& mesh, std::vector<PathRole>& paths) {
  const fs::path numbers = heavy_data_file(mesh);
  if (!numbers.empty()) paths.push_back({role, numbers, PathUse::kWrittenFile});
}

void add_outputs(const OutputOptions& output, std::vector<PathRole>& paths) {
  const bool to_stream = output.mesh.empty() || output.mesh == "-";
  const std::string system = coordinate_system_file(output.mesh).string();
  paths.push_back({"the mesh", output.mesh, PathUse::kWrittenFile});
  add_numbers("the numbers of the mesh", output.mesh, paths);
  if (!to_stream && output.tiles)
    paths.push_back(
        {"the directory of the tiles", tile_directory_of(output.mesh), PathUse::kWrittenDirectory});
  paths.push_back(
      {"the coordinate system beside the mesh", system, PathUse::kWrittenFile, false, false});
  paths.push_back({"the shift of coordinates beside the mesh", shift_file(output.mesh),
                   PathUse::kWrittenFile, false, false});
  paths.push_back({"the directory of the tileset", output.tileset, PathUse::kWrittenDirectory});
  const std::string simplified = simplified_file(output).string();
  paths.push_back({"the simplified mesh", simplified, PathUse::kWrittenFile});
  add_numbers("the numbers of the simplified mesh", simplified, paths);
  paths.push_back({"the coordinate system beside the simplified mesh",
                   coordinate_system_file(simplified), PathUse::kWrittenFile, false, false});
  paths.push_back({"the shift of coordinates beside the simplified mesh", shift_file(simplified),
                   PathUse::kWrittenFile, false, false});
  paths.push_back({"the file of polygons", output.polygons, PathUse::kWrittenFile});
  paths.push_back({"the medial axis", output.medial_axis, PathUse::kWrittenFile});
  paths.push_back({"the report", output.report, PathUse::kWrittenFile});
  paths.push_back({"the report's page", report_page(output.report), PathUse::kWrittenFile});
  paths.push_back({"the picture", output.picture, PathUse::kWrittenFile});
}

}  // namespace

std::vector<PathRole> job_paths(const Job& job, const std::vector<std::string>& files,
                                const std::string& job_file) {
  std::vector<PathRole> paths;
  const fs::path work_dir = work_dir_of(job);
  add_outputs(job.output, paths);
  paths.push_back({"the work directory", work_dir, PathUse::kWorkDirectory});
  paths.push_back({"the log", work_dir / kLogName, PathUse::kWrittenFile, true});
  paths.push_back({"the steps of the run", work_dir / kStepsName, PathUse::kWrittenFile, true});
  paths.push_back({"the current directory", fs::path("."), PathUse::kReadDirectory});
  paths.push_back({"the job file", job_file, PathUse::kReadFile});
  paths.push_back({"the file of poses", job.input.poses, PathUse::kReadFile});
  paths.push_back({"the trajectory", job.input.trajectory, PathUse::kReadFile});
  if (names_area_file(job.input))
    paths.push_back({"the file of the crop's area", job.input.crop_area, PathUse::kReadFile});
  for (const std::string& file : files)
    paths.push_back({"a scan of the job", file, PathUse::kReadFile});
  return paths;
}

void check_job_paths(const Job& job, const std::vector<std::string>& files,
                     const std::string& job_file) {
  check_paths(job_paths(job, files, job_file));
  check_output_names(job.output, setting_name(job, "output.report"));
}

}  // namespace orbweave
