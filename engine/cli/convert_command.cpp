// orbweave convert: a cloud or a mesh from one format to another.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>

#include "engine/cli/commands.h"
#include "engine/cli/file_kind.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/normals/normals_from_faces.h"
#include "engine/validation/cloud_facts.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_writer.h"
#include "io/points/coordinate_system_file.h"
#include "io/points/point_source.h"
#include "io/shown_text.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;

struct ConvertOptions {
  std::string in;
  std::string out;  ///< "-": PLY to standard output
  bool normals_from_faces = false;
  bool float_positions = false;
};

MeshWriterOptions writer_options(const ConvertOptions& options) {
  return {.float_positions = options.float_positions, .comments = {}};
}

void print_written(const ConvertOptions& options, std::uint64_t points, std::uint64_t triangles) {
  if (options.out == "-") return;
  std::cout << shown(options.out) << ": " << format_count(points)
            << (triangles > 0 ? " vertices" : " points");
  if (triangles > 0) std::cout << ", " << format_count(triangles) << " triangles";
  std::cout << "\n";
}

/// A source that a request to stop ends.
class StoppableSource : public PointSource {
 public:
  StoppableSource(const std::string& path, const StopToken& stop)
      : source_(open_point_source(path)), stop_(stop) {}
  const PointSchema& schema() const override { return source_->schema(); }
  std::optional<std::uint64_t> declared_points() const override {
    return source_->declared_points();
  }
  bool read(PointCloud& batch, std::size_t capacity) override {
    check_interruption(stop_);
    return source_->read(batch, capacity);
  }
  std::uint64_t bytes_read() const override { return source_->bytes_read(); }
  std::uint64_t bytes_total() const override { return source_->bytes_total(); }

 private:
  std::unique_ptr<PointSource> source_;
  const StopToken& stop_;
};

/// How far float coordinates move the points of what went by.
class Shift {
 public:
  void add(const std::vector<Vec3>& positions) {
    for (const Vec3& p : positions)
      for (int axis = 0; axis < 3; ++axis)
        if (std::isfinite(p[axis]))
          largest_ = std::max(largest_,
                              std::abs(p[axis] - static_cast<double>(static_cast<float>(p[axis]))));
  }
  /// Warns where points move by more than a thousandth of the spacing in the file `in`.
  void warn(const std::string& in, const StopToken& stop) const {
    if (largest_ == 0.0 || in == "-") return;
    StoppableSource source(in, stop);
    StoppableSource again(in, stop);
    const std::optional<double> spacing = cloud_facts(source, &again).spacing;
    if (spacing && largest_ > 1e-3 * *spacing)
      print_warning("--float moves points by up to " + format_number(largest_) +
                    ", more than a thousandth of their spacing " + format_number(*spacing));
  }

 private:
  double largest_ = 0.0;
};

void warn_of_shift(const PointCloud& points, const ConvertOptions& options, const StopToken& stop) {
  Shift shift;
  if (options.float_positions) shift.add(points.positions);
  shift.warn(options.in, stop);
}

/// Beside the file, where other programs look for it; the formats have no place for it.
void keep_coordinate_system(const ConvertOptions& options, const std::string& system) {
  const std::filesystem::path beside = write_coordinate_system(options.out, system);
  if (!beside.empty()) note_written(beside.string());
  const std::string problem = written_system(system).problem;
  if (!problem.empty())
    print_warning("the coordinate system of " + options.in + ", " + shown(system) + ": " + problem);
}

void convert_mesh(const ConvertOptions& options, const StopToken& stop) {
  const TriangleMesh mesh = read_mesh(options.in);
  write_mesh(options.out, mesh, writer_options(options));
  note_written(options.out);
  keep_coordinate_system(options, coordinate_system_beside(options.in));
  warn_of_shift(mesh.vertices, options, stop);
  print_written(options, mesh.vertices.size(), mesh.triangles.size());
}

/// The vertices with everything they carry; normals that the file gave give way to the faces'.
void convert_to_oriented_cloud(const ConvertOptions& options, const StopToken& stop) {
  TriangleMesh mesh = read_mesh(options.in);
  if (mesh.triangles.empty())
    throw_bad_input("the mesh has no faces to take normals from", {.file = options.in});
  mesh.vertices.normals = normals_from_faces(mesh);
  mesh.vertices.schema.has_normals = true;
  write_cloud(options.out, mesh.vertices, writer_options(options));
  note_written(options.out);
  keep_coordinate_system(options, coordinate_system_beside(options.in));
  warn_of_shift(mesh.vertices, options, stop);
  print_written(options, mesh.vertices.size(), 0);
}

/// A header comes before the points. Where it is not certain how many there are, a file is read
/// twice.
std::uint64_t count_points(const std::string& path, const StopToken& stop) {
  const auto source = open_point_source(path);
  std::uint64_t points = 0;
  for (PointCloud batch; source->read(batch, kBatchPoints); points += batch.size())
    check_interruption(stop);
  return points;
}

/// Points from standard input that come without their number are kept until it is known.
void convert_stream(PointSource& source, const ConvertOptions& options) {
  const PointCloud cloud = read_all(source);
  write_cloud(options.out, cloud, writer_options(options));
  note_written(options.out);
  print_written(options, cloud.size(), 0);
}

void convert_cloud(const ConvertOptions& options, const StopToken& stop) {
  const auto source = open_point_source(options.in);
  const bool is_known = source->keeps_declared_points();
  if (!is_known && options.in == "-") return convert_stream(*source, options);
  const std::uint64_t points =
      is_known ? source->declared_points().value_or(0) : count_points(options.in, stop);
  const MeshHeader header{.vertices = points, .is_cloud = true, .schema = source->schema()};
  const auto writer = open_mesh_writer(options.out, header, writer_options(options));
  Shift shift;
  for (PointCloud batch; source->read(batch, kBatchPoints);) {
    check_interruption(stop);
    if (options.float_positions) shift.add(batch.positions);
    writer->write_vertices(batch);
  }
  writer->finish();
  note_written(options.out);
  keep_coordinate_system(options, source->coordinate_system());
  shift.warn(options.in, stop);
  print_written(options, points, 0);
}

void check_places(const ConvertOptions& options) {
  const std::vector<PathRole> paths = {{"the file that is read", options.in, PathUse::kReadFile},
                                       {"the file", options.out, PathUse::kWrittenFile},
                                       {"the coordinate system beside the file",
                                        coordinate_system_file(options.out), PathUse::kWrittenFile,
                                        false, false}};
  check_paths(paths);
}

void convert(const ConvertOptions& options, const StopToken& stop) {
  check_places(options);
  const bool mesh = is_mesh_file(options.in);
  if (options.normals_from_faces && !mesh)
    throw_bad_input("is no mesh, so there are no faces to take normals from",
                    {.file = options.in, .expected = "a .ply, .obj or .stl file with faces"});
  if ((!mesh || options.normals_from_faces) && is_mesh_only_format(options.out))
    throw_usage("a cloud cannot become a mesh by conversion",
                {.file = options.out,
                 .expected = "a .ply, .xyz or .csv name",
                 .advice = "'orbweave reconstruct' makes a mesh of a cloud."});
  if (options.normals_from_faces) return convert_to_oriented_cloud(options, stop);
  if (mesh && !is_cloud_only_format(options.out)) return convert_mesh(options, stop);
  convert_cloud(options, stop);
}

}  // namespace

void add_convert_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = program.add_subcommand(
      "convert", "Convert a cloud or a mesh between the formats that are read and written");
  command->add_option("IN", options->in, "The file to read; - reads a cloud from standard input")
      ->type_name("")
      ->required();
  command->add_option("OUT", options->out, "The file to write; - writes PLY to standard output")
      ->type_name("")
      ->required();
  command->add_flag("--normals-from-faces", options->normals_from_faces,
                    "Make an oriented cloud of a mesh: its vertices, with normals from its faces");
  command->add_flag("--float", options->float_positions,
                    "Write 4-byte coordinates where the format has a choice");
  command->footer(
      "A mesh stays a mesh unless OUT is a format of clouds (.xyz, .csv) or\n"
      "--normals-from-faces is given.\n\n"
      "Example:\n  orbweave convert --normals-from-faces bunny.ply bunny_points.ply\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { convert(*options, stop); });
  });
}

}  // namespace orbweave
