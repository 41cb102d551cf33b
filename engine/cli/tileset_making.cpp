#include "engine/cli/tileset_making.h"

#include <span>

#include "engine/cli/files_beside.h"
#include "io/meshes/mesh_reader.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "partition/executor.h"

namespace orbweave {

namespace fs = std::filesystem;

namespace {

/// Bounds of vertices decide which axis is upright where nothing else does.
int upright_axis_of(const std::string& file, const Job& job, const std::string& system) {
  UpAxis up = job.output.picture_up;
  if (up == UpAxis::kAuto) up = up_axis_of_scans(std::span(&file, 1), system);
  if (up != UpAxis::kAuto) return upright_axis(up, {});
  Box bounds;
  const auto mesh = open_mesh_stream(file);
  for (PointCloud batch; mesh->read_vertices(batch, std::size_t{1} << 16);)
    for (const Vec3& position : batch.positions)
      if (is_finite(position)) bounds.extend(position);
  return upright_axis(up, bounds);
}

}  // namespace

TilesetOptions tileset_options(const std::string& mesh, const fs::path& work_directory,
                               const Job& job) {
  TilesetOptions options;
  options.levels.memory_bytes = job.partition.memory_bytes;
  options.levels.threads = job.run.threads > 0 ? job.run.threads : available_threads();
  options.levels.directory = work_directory;
  options.compression = job.output.tileset_compression;
  options.coordinate_system = coordinate_system_beside(mesh);
  options.up_axis = upright_axis_of(mesh, job, options.coordinate_system);
  return options;
}

TilesetFacts make_tileset(const std::string& mesh_file, const fs::path& directory,
                          const TilesetOptions& options, Progress& progress,
                          const StopToken& stop) {
  const auto mesh = open_mesh_stream(mesh_file);
  progress.begin_stage("read", mesh->faces(), "triangles");
  TilesetEvents events;
  events.read = [&](std::uint64_t triangles) { progress.advance(triangles); };
  events.planned = [&](std::uint32_t tiles) {
    progress.end_stage();
    progress.begin_stage("tiles", tiles, "tiles");
  };
  events.written = [&] { progress.advance(1); };
  events.measuring = [&] {
    progress.end_stage();
    progress.begin_stage("measure", 0, "levels");
  };
  TilesetFacts facts;
  name_in_errors(mesh_file,
                 [&] { facts = write_tileset(*mesh, directory, options, events, stop); });
  progress.end_stage();
  return facts;
}

}  // namespace orbweave
