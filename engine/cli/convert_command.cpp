// orbweave convert: a cloud or a mesh from one format to another.
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <iostream>
#include <memory>

#include "engine/cli/commands.h"
#include "engine/cli/output.h"
#include "engine/normals/normals_from_faces.h"
#include "io/error.h"
#include "io/mesh_reader.h"
#include "io/mesh_writer.h"
#include "io/point_source.h"
#include "io/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;

struct ConvertOptions {
  std::string in;
  std::string out;  ///< "-": PLY to standard output
  bool normals_from_faces = false;
  bool float_positions = false;
};

bool ends_with_any(std::string name, std::initializer_list<const char*> extensions) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const char* extension) { return name.ends_with(extension); });
}

bool is_mesh_only_format(const std::string& name) { return ends_with_any(name, {".obj", ".stl"}); }
bool is_cloud_only_format(const std::string& name) {
  return ends_with_any(name, {".xyz", ".csv", ".xyz.gz", ".csv.gz"});
}

MeshWriterOptions writer_options(const ConvertOptions& options) {
  return {.float_positions = options.float_positions, .comments = {}};
}

void print_written(const ConvertOptions& options, std::uint64_t points, std::uint64_t triangles) {
  if (options.out == "-") return;
  std::cout << options.out << ": " << format_count(points)
            << (triangles > 0 ? " vertices" : " points");
  if (triangles > 0) std::cout << ", " << format_count(triangles) << " triangles";
  std::cout << "\n";
}

void convert_mesh(const ConvertOptions& options) {
  const TriangleMesh mesh = read_mesh(options.in);
  write_mesh(options.out, mesh, writer_options(options));
  print_written(options, mesh.vertices.size(), mesh.triangles.size());
}

/// The vertices with everything they carry; normals that the file gave give way to the faces'.
void convert_to_oriented_cloud(const ConvertOptions& options) {
  TriangleMesh mesh = read_mesh(options.in);
  if (mesh.triangles.empty())
    throw_bad_input("the mesh has no faces to take normals from", {.file = options.in});
  mesh.vertices.normals = normals_from_faces(mesh);
  mesh.vertices.schema.has_normals = true;
  write_cloud(options.out, mesh.vertices, writer_options(options));
  print_written(options, mesh.vertices.size(), 0);
}

/// A header comes before the points, so a file that does not say how many it has is read twice.
std::uint64_t count_points(const std::string& path, const StopToken& stop) {
  const auto source = open_point_source(path);
  if (source->declared_points()) return *source->declared_points();
  std::uint64_t points = 0;
  for (PointCloud batch; source->read(batch, kBatchPoints); points += batch.size()) stop.check();
  return points;
}

void convert_cloud(const ConvertOptions& options, const StopToken& stop) {
  const std::uint64_t points = count_points(options.in, stop);
  const auto source = open_point_source(options.in);
  const MeshHeader header{.vertices = points, .is_cloud = true, .schema = source->schema()};
  const auto writer = open_mesh_writer(options.out, header, writer_options(options));
  for (PointCloud batch; source->read(batch, kBatchPoints);) {
    stop.check();
    writer->write_vertices(batch);
  }
  writer->finish();
  print_written(options, points, 0);
}

bool is_mesh(const std::string& name) {
  return ends_with_any(name, {".ply", ".ply.gz", ".obj", ".stl"}) && holds_faces(name);
}

void convert(const ConvertOptions& options, const StopToken& stop) {
  const bool mesh = is_mesh(options.in);
  if (options.normals_from_faces && !mesh)
    throw_bad_input("is no mesh, so there are no faces to take normals from",
                    {.file = options.in, .expected = "a .ply, .obj or .stl file with faces"});
  if ((!mesh || options.normals_from_faces) && is_mesh_only_format(options.out))
    throw_usage("a cloud cannot become a mesh by conversion",
                {.file = options.out,
                 .expected = "a .ply, .xyz or .csv name",
                 .advice = "'orbweave reconstruct' makes a mesh of a cloud."});
  if (options.normals_from_faces) return convert_to_oriented_cloud(options);
  if (mesh && !is_cloud_only_format(options.out)) return convert_mesh(options);
  convert_cloud(options, stop);
}

}  // namespace

void add_convert_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = program.add_subcommand(
      "convert", "Convert a cloud or a mesh between the formats that are read and written");
  command->add_option("IN", options->in, "The file to read")->type_name("")->required();
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
