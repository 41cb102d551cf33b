#include "engine/pipeline/output/power_crust_files.h"

#include <cstring>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "engine/pipeline/stage/method_costs.h"
#include "engine/pipeline/surface/power_crust_stage.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/meshes/shift_file.h"
#include "io/store/chunk_points.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

bool is_ply(const std::string& file) {
  const auto named = format_of_name(file);
  return named && named->facts.format == FileFormat::kPly;
}

void check_file(const Job& job, const char* key, const std::string& file, bool is_held,
                const char* formats) {
  if (file.empty()) return;
  if (!has_own_vertices(job.reconstruct.method))
    throw_usage("only a Power Crust has polygons and a medial axis",
                {.file = file,
                 .place = setting_name(job, key),
                 .found = setting(job, "reconstruct.method", method_name(job)),
                 .expected = setting(job, "reconstruct.method", "power_crust")});
  if (is_held && file != "-") return;
  throw_usage("the format cannot be written there",
              {.file = file, .place = setting_name(job, key), .found = file, .expected = formats});
}

std::uint64_t bytes_of(const std::string& file) {
  std::error_code failed;
  const std::uintmax_t bytes = std::filesystem::file_size(file, failed);
  return failed ? 0 : static_cast<std::uint64_t>(bytes);
}

/// The balls as points with the attribute radius.
PointCloud cloud_of(const MedialAxis& axis) {
  PointCloud cloud;
  cloud.schema.attributes = {{"radius", ScalarType::kFloat64}};
  cloud.positions = axis.centers;
  cloud.attributes.resize(axis.radii.size() * sizeof(double));
  if (!axis.radii.empty())
    std::memcpy(cloud.attributes.data(), axis.radii.data(), cloud.attributes.size());
  return cloud;
}

std::uint64_t write_polygon_file(const Partition& vertices, const VertexColumns& columns,
                                 const MeshWriterOptions& options, StageRunner& runner) {
  const std::string& file = runner.job.output.polygons;
  const PolygonFaces faces = load_polygons(runner.store);
  PointCloud points = load_points(runner.store, 0, columns.stored, vertices.stage);
  columns.colors.apply(points);
  write_polygons(file, points, faces, options);
  write_shift(file, options.origin);
  runner.note("polygons: " + format_count(faces.size()) + " over " + format_count(points.size()) +
              " vertices");
  return bytes_of(file);
}

std::uint64_t write_medial_axis(const MeshWriterOptions& options, StageRunner& runner) {
  const std::string& file = runner.job.output.medial_axis;
  const MedialAxis axis = load_medial_axis(runner.store);
  write_cloud(file, cloud_of(axis), options);
  write_shift(file, options.origin);
  runner.note("medial axis: " + format_count(axis.radii.size()) + " balls");
  return bytes_of(file);
}

}  // namespace

void check_power_crust_files(const Job& job) {
  const OutputOptions& output = job.output;
  check_file(job, "output.polygons", output.polygons, holds_polygons(output.polygons),
             "the name of a .ply or .obj file");
  check_file(job, "output.medial_axis", output.medial_axis, is_ply(output.medial_axis),
             "the name of a .ply file");
}

std::uint64_t write_power_crust_files(const Partition& vertices, const VertexColumns& columns,
                                      const MeshWriterOptions& options, StageRunner& runner) {
  const OutputOptions& output = runner.job.output;
  MeshWriterOptions plain = options;
  plain.has_confidence = false;
  std::uint64_t bytes = 0;
  if (!output.polygons.empty()) bytes += write_polygon_file(vertices, columns, plain, runner);
  runner.stop.check();
  if (!output.medial_axis.empty()) bytes += write_medial_axis(plain, runner);
  return bytes;
}

}  // namespace orbweave
