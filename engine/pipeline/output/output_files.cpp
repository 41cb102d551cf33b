#include "engine/pipeline/output/output_files.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "io/job/simplified_file.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/shift_file.h"
#include "io/meshes/tile_directory.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/report.h"
#include "io/system/owned_files.h"

namespace orbweave {

std::vector<OutputFile> written_outputs(const OutputOptions& output, BesideMesh beside) {
  std::vector<OutputFile> files;
  const auto add = [&](const char* role, std::filesystem::path file) {
    if (!file.empty()) files.push_back({role, std::move(file)});
  };
  if (output.mesh != "-")
    add(output.tiles ? "tiles" : "mesh",
        output.tiles ? tile_directory_of(output.mesh) : std::filesystem::path(output.mesh));
  add("numbers", heavy_data_file(output.mesh));
  if (beside.system) add("system", coordinate_system_file(output.mesh));
  if (beside.shift) add("shift", shift_file(output.mesh));
  add("tileset", output.tileset);
  const std::filesystem::path simplified = simplified_file(output);
  add("simplified", simplified);
  add("numbers", heavy_data_file(simplified));
  const std::filesystem::path system = coordinate_system_file(simplified);
  if (beside.system && system != coordinate_system_file(output.mesh)) add("system", system);
  if (beside.shift_of_simplified) add("shift", shift_file(simplified));
  add("polygons", output.polygons);
  if (beside.shift) add("shift", shift_file(output.polygons));
  add("medial axis", output.medial_axis);
  if (beside.shift) add("shift", shift_file(output.medial_axis));
  add("report", output.report);
  add("page", report_page(output.report));
  add("picture", output.picture);
  return files;
}

namespace {

/// Whether the job writes this file itself, such as a tileset named as tiles would be.
bool is_written(const std::filesystem::path& file, const OutputOptions& output) {
  std::error_code ignored;
  return std::ranges::any_of(written_outputs(output, {}), [&](const OutputFile& written) {
    return std::filesystem::equivalent(written.file, file, ignored);
  });
}

}  // namespace

std::vector<OutputFile> older_outputs(const OutputOptions& output, bool has_system) {
  std::vector<OutputFile> candidates;
  const std::filesystem::path system = coordinate_system_file(output.mesh);
  if (system.empty()) return {};  // a stream or a device has nothing beside it
  if (output.tiles)
    candidates.push_back({"mesh", output.mesh});
  else
    candidates.push_back({"tiles", tile_directory_of(output.mesh)});
  if (!has_system) candidates.push_back({"system", system});
  std::error_code ignored;
  std::erase_if(candidates, [&](const OutputFile& candidate) {
    return !std::filesystem::exists(candidate.file, ignored) || is_written(candidate.file, output);
  });
  return candidates;
}

void clear_older_outputs(StageRunner& runner, bool has_system) {
  const std::shared_ptr<OwnedFiles> record = runner.store.record();
  for (const OutputFile& older : older_outputs(runner.job.output, has_system)) {
    std::error_code ignored;
    const bool is_file = std::filesystem::is_regular_file(older.file, ignored);
    if (is_file ? record->remove(older.file) == OwnedFiles::Removal::kRemoved
                : remove_tile_directory(older.file, *record))
      runner.note(older.file.string() + " of an earlier run is removed: it is not of this result");
    else
      runner.warn(older.file.string() +
                  " was there before and is not of this run; remove it if an earlier run has left "
                  "it");
  }
}

}  // namespace orbweave
