// orbweave convert: a cloud or a mesh from one format to another.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <vector>

#include "engine/cli/commands.h"
#include "engine/cli/file_kind.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/selected_source.h"
#include "engine/cli/signals.h"
#include "engine/normals/normals_from_faces.h"
#include "engine/pipeline/stage/writer_options.h"
#include "engine/validation/cloud_facts.h"
#include "engine/validation/mesh_facts.h"
#include "io/error.h"
#include "io/job/output_origin.h"
#include "io/meshes/heavy_data.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/points/color_depth.h"
#include "io/points/coordinate_system_file.h"
#include "io/points/point_source.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/shown_text.h"
#include "io/system/path_roles.h"
#include "io/text/file_format.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;

/// Keys of a job file that are options here, too.
constexpr std::array<std::string_view, 2> kKeys = {"output.origin", "output.colors"};

struct ConvertOptions {
  std::string in;
  std::string out;  ///< "-": PLY to standard output
  bool normals_from_faces = false;
  bool float_positions = false;
  JobArguments keys;

  /// What a job that writes the file would ask for.
  Job job() const {
    Job job = settings_of(keys);
    job.output.mesh = out;
    job.output.float_positions = float_positions;
    return job;
  }
};

void print_written(const ConvertOptions& options, std::uint64_t points, std::uint64_t triangles,
                   Vec3 origin) {
  if (options.out == "-") return;
  std::cout << shown(options.out) << ": "
            << (triangles > 0 ? show_counts(points, triangles)
                              : counted(points, "point", "points"));
  if (origin != Vec3{}) std::cout << ", counted from " << origin_text(origin);
  std::cout << "\n";
}

/// A source that a request to stop ends.
class StoppableSource : public PointSource {
 public:
  StoppableSource(std::unique_ptr<PointSource> source, const StopToken& stop)
      : source_(std::move(source)), stop_(stop) {}
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

MeshWriterOptions writer_options(const Job& job, Vec3 origin) {
  MeshWriterOptions options;
  options.float_positions = job.output.float_positions;
  options.origin = origin;
  return options;
}

bool writes_floats(const Job& job) {
  return has_float_coordinates(job.output.mesh, writer_options(job, {}));
}

/// Whether coordinates of the file may differ from those that are read.
bool may_round(const Job& job) {
  return writes_floats(job) || job.output.origin_rule == OriginRule::kGiven;
}

/// The extent of a cloud, and whether a coordinate changes where it is written as the file has its
/// numbers, counted from the given origin.
class Rounding {
 public:
  explicit Rounding(const Job& job) : floats_(writes_floats(job)) {
    if (job.output.origin_rule == OriginRule::kGiven) origin_ = job.output.origin;
  }
  void add(const std::vector<Vec3>& positions) {
    for (const Vec3& p : positions) {
      if (!is_finite(p)) continue;
      bounds_.extend(p);
      for (int axis = 0; axis < 3; ++axis) {
        const double local = p[axis] - origin_[axis];
        const double kept = floats_ ? static_cast<double>(static_cast<float>(local)) : local;
        moves_any_ = moves_any_ || kept + origin_[axis] != p[axis];
      }
    }
  }
  bool floats() const { return floats_; }
  bool moves_any() const { return moves_any_; }
  const Box& bounds() const { return bounds_; }

 private:
  bool floats_;
  Vec3 origin_;
  Box bounds_;
  bool moves_any_ = false;
};

/// The spacing of the points that are selected; 0: not known.
double spacing_of(const std::string& in, const SelectedSource& selected, const StopToken& stop) {
  if (in == "-") return 0.0;
  StoppableSource source(selected.open(in), stop);
  StoppableSource again(selected.open(in), stop);
  return cloud_facts(source, &again).spacing.value_or(0.0);
}

/// Where the coordinates of the file are counted from; throws where they would lose too much.
/// `spacing`: of the points, asked for only where one of them would be moved.
Vec3 chosen_origin(const Job& job, const Rounding& rounding,
                   const std::function<double()>& spacing) {
  if (!rounding.moves_any())
    return job.output.origin_rule == OriginRule::kGiven ? job.output.origin : Vec3{};
  const OutputOrigin chosen =
      output_origin(job.output, rounding.floats(), rounding.bounds(), spacing());
  const std::string warning = check_output_origin(job, chosen);
  if (!warning.empty()) print_warning(warning);
  return chosen.origin;
}

Vec3 origin_of_mesh(const Job& job, const TriangleMesh& mesh) {
  Rounding rounding(job);
  if (may_round(job)) rounding.add(mesh.vertices.positions);
  return chosen_origin(job, rounding, [&] { return vertex_spacing(mesh); });
}

/// A pass over the points before they are written, where their coordinates may change.
Vec3 origin_of_cloud(const Job& job, const std::string& in, const SelectedSource& selected,
                     const StopToken& stop) {
  Rounding rounding(job);
  if (may_round(job)) {
    StoppableSource source(selected.open(in), stop);
    for (PointCloud batch; source.read(batch, kBatchPoints);) rounding.add(batch.positions);
  }
  return chosen_origin(job, rounding, [&] { return spacing_of(in, selected, stop); });
}

/// Whether any 16-bit colour of a file exceeds 8 bits, where its colours are to have 8 bits.
bool colors_exceed_8_bits(const Job& job, const PointSchema& schema, const std::string& in,
                          const SelectedSource& selected, const StopToken& stop) {
  const std::optional<WideColors> colors = wide_colors(schema);
  if (!colors || job.output.color_bits != 8) return false;
  bool exceed = false;
  StoppableSource source(selected.open(in), stop);
  for (PointCloud batch; !exceed && source.read(batch, kBatchPoints);)
    exceed = exceed_8_bits(batch, *colors);
  return exceed;
}

void apply_colors(const Job& job, PointCloud& points) {
  const std::optional<WideColors> colors = wide_colors(points.schema);
  if (colors)
    ColorDepth(points.schema, job.output.color_bits, exceed_8_bits(points, *colors)).apply(points);
}

void write_beside(const ConvertOptions& options, Vec3 origin, const std::string& system) {
  write_files_beside(options.out, options.in, system, origin);
}

/// What faces tell of patches beside the hole; a format without a place for it leaves it out.
void keep_confidence(const ConvertOptions& options, const TriangleMesh& mesh,
                     MeshWriterOptions& written) {
  std::error_code ignored;
  if (mesh.hole.empty() || std::ranges::max(mesh.hole) > kMostIdWithConfidence ||
      !std::filesystem::is_regular_file(options.in, ignored))
    return;
  for (const auto& [id, confidence] : hole_confidence(options.in))
    note_confidence(written.confidence, id, confidence);
  written.has_confidence = !written.confidence.empty();
}

/// Of triangles alone: what a file of facets does not hold. Empty: it holds everything.
std::string vertices_without_place(const std::string& file, const TriangleMesh& mesh) {
  const std::optional<NamedFormat> named = format_of_name(file);
  if (!named || named->facts.format != FileFormat::kStl) return {};
  const std::vector<std::uint8_t> used = used_vertices(mesh.vertices.size(), mesh.triangles);
  const auto lost = static_cast<std::uint64_t>(std::ranges::count(used, 0));
  return lost == 0 ? std::string() : counted(lost, "vertex", "vertices") + " without a triangle";
}

void convert_mesh(const ConvertOptions& options) {
  const Job job = options.job();
  std::vector<std::string> left_out_of_file;
  TriangleMesh mesh = read_mesh(options.in, &left_out_of_file);
  warn_of_left_out(options.in, left_out_of_file);
  apply_colors(job, mesh.vertices);
  const Vec3 origin = origin_of_mesh(job, mesh);
  const std::string system = coordinate_system_beside(options.in);
  MeshWriterOptions written = writer_options(job, origin);
  const UpAxis up = up_axis_of_scans(std::span(&options.in, 1), system);
  written.up_axis = upright_axis(up, mesh.vertices.bounds());
  keep_confidence(options, mesh, written);
  write_mesh(options.out, mesh, written);
  note_written(options.out);
  write_beside(options, origin, system);
  print_written(options, mesh.vertices.size(), mesh.triangles.size(), origin);
  std::vector<std::string> without_place;
  if (fills_holes(mesh)) without_place = patches_without_place(options.out, written.has_confidence);
  if (const std::string lost = vertices_without_place(options.out, mesh); !lost.empty())
    without_place.push_back(lost);
  const std::string left_out = left_out_of(options.out, mesh.vertices.schema, without_place);
  if (options.out != "-" && !left_out.empty()) std::cout << "left out: " << left_out << "\n";
}

/// The vertices with everything they carry; normals that the file gave give way to the faces'.
void convert_to_oriented_cloud(const ConvertOptions& options) {
  const Job job = options.job();
  TriangleMesh mesh = read_mesh(options.in);
  if (mesh.triangles.empty())
    throw_bad_input("the mesh has no faces to take normals from", {.file = options.in});
  mesh.vertices.normals = normals_from_faces(mesh);
  mesh.vertices.schema.has_normals = true;
  apply_colors(job, mesh.vertices);
  const Vec3 origin = origin_of_mesh(job, mesh);
  write_cloud(options.out, mesh.vertices, writer_options(job, origin));
  note_written(options.out);
  write_beside(options, origin, coordinate_system_beside(options.in));
  print_written(options, mesh.vertices.size(), 0, origin);
}

/// A header comes before the points. Where it is not certain how many there are, a file is read
/// twice.
std::uint64_t count_points(PointSource& source, const StopToken& stop) {
  std::uint64_t points = 0;
  for (PointCloud batch; source.read(batch, kBatchPoints); points += batch.size())
    check_interruption(stop);
  return points;
}

/// What a selection left of the cloud is not all of it, nor is what a reader takes for no point.
void print_left_out(const PointSource& source, const ConvertOptions& options) {
  if (options.out == "-") return;
  for (const auto& [reason, count] : source.left_out())
    std::cout << format_count(count) << " dropped: " << reason << "\n";
}

/// Where scanners stood has no place in the files that are written, and turns normals the right
/// way.
void print_scanners_left_out(const PointSource& source, const ConvertOptions& options) {
  if (options.out == "-") return;
  const std::vector<ScannerPlace> places = scanner_places(source);
  if (places.empty()) return;
  std::string place = origin_text(places.front().vector);
  std::erase(place, ' ');
  std::cout << "left out: "
            << (places.size() > 1
                    ? "the places of " + format_count(places.size()) +
                          " scanners; a job that reads the file itself turns normals towards them"
                    : "the place of the scanner; --scanner=" + place +
                          " of 'orbweave reconstruct' turns normals towards it")
            << "\n";
}

/// Points from standard input that come without their number, whose coordinates may change or whose
/// colours may have to be scaled are kept until all are known.
void convert_stream(PointSource& source, const ConvertOptions& options) {
  const Job job = options.job();
  PointCloud cloud = read_all(source);
  apply_colors(job, cloud);
  Rounding rounding(job);
  if (may_round(job)) rounding.add(cloud.positions);
  const Vec3 origin = chosen_origin(job, rounding, [] { return 0.0; });
  write_cloud(options.out, cloud, writer_options(job, origin));
  note_written(options.out);
  write_beside(options, origin, source.coordinate_system());
  print_left_out(source, options);
  print_written(options, cloud.size(), 0, origin);
  print_scanners_left_out(source, options);
}

/// What has to be known of a cloud before the first byte is written.
struct CloudToWrite {
  std::uint64_t points = 0;
  Vec3 origin;
  bool has_wide_colors = false;  ///< colours exceed 8 bits
};

/// Returns false, with nothing written, where a colour exceeds 8 bits that was not said to.
bool write_points(PointSource& source, const ConvertOptions& options, const CloudToWrite& cloud,
                  const StopToken& stop) {
  const Job job = options.job();
  const std::optional<WideColors> wide = wide_colors(source.schema());
  const ColorDepth colors(source.schema(), job.output.color_bits, cloud.has_wide_colors);
  const MeshHeader header{.vertices = cloud.points, .is_cloud = true, .schema = colors.written()};
  const auto writer = open_mesh_writer(options.out, header, writer_options(job, cloud.origin));
  for (PointCloud batch; source.read(batch, kBatchPoints);) {
    check_interruption(stop);
    if (colors.changes() && !cloud.has_wide_colors && exceed_8_bits(batch, *wide)) return false;
    colors.apply(batch);
    writer->write_vertices(batch);
  }
  writer->finish();
  return true;
}

/// A mesh is recognised by its file. What comes from a stream is read as points, and would lose its
/// faces.
void require_no_faces(const PointSource& source, const ConvertOptions& options) {
  const std::string faces = source.facts().faces;
  if (faces.empty() || is_cloud_only_format(options.out)) return;
  throw_bad_input("a mesh is not converted from a stream",
                  {.file = options.in == "-" ? "standard input" : options.in,
                   .found = faces,
                   .expected = "points alone, or the name of a file on disk",
                   .advice = "Save it first, such as by: cat > mesh.ply"});
}

void convert_cloud(const ConvertOptions& options, const StopToken& stop) {
  const Job job = options.job();
  const SelectedSource selected(options.keys);
  auto source = selected.open(options.in);
  require_no_faces(*source, options);
  warn_of_left_out(options.in == "-" ? "standard input" : options.in, not_read(source->facts()));
  const bool is_known = source->keeps_declared_points();
  const bool has_wide_colors =
      job.output.color_bits == 8 && wide_colors(source->schema()).has_value();
  const bool is_asked_twice = !is_known || may_round(job) || has_wide_colors;
  // A pipe can be read only once.
  if (is_asked_twice && !std::filesystem::is_regular_file(options.in))
    return convert_stream(*source, options);
  const std::uint64_t points = is_known ? source->declared_points().value_or(0)
                                        : count_points(*selected.open(options.in), stop);
  const Vec3 origin = origin_of_cloud(job, options.in, selected, stop);
  // Colours are taken for 8-bit ones in wide fields until one exceeds them: of other scans mostly
  // the first. What a stream got cannot be taken back.
  const bool is_stream = coordinate_system_file(options.out).empty();
  const bool exceed =
      is_stream && colors_exceed_8_bits(job, source->schema(), options.in, selected, stop);
  if (!write_points(*source, options, {points, origin, exceed}, stop)) {
    source = selected.open(options.in);
    write_points(*source, options, {points, origin, true}, stop);
  }
  note_written(options.out);
  write_beside(options, origin, source->coordinate_system());
  print_left_out(*source, options);
  print_written(options, points, 0, origin);
  print_scanners_left_out(*source, options);
}

void check_places(const ConvertOptions& options) {
  const std::vector<PathRole> paths = {
      {"the file that is read", options.in, PathUse::kReadFile},
      {"the file", options.out, PathUse::kWrittenFile},
      {"the numbers of the file", heavy_data_file(options.out), PathUse::kWrittenFile},
      {"the coordinate system beside the file", coordinate_system_file(options.out),
       PathUse::kWrittenFile, false, false},
      {"the shift of coordinates beside the file", shift_file(options.out), PathUse::kWrittenFile,
       false, false}};
  check_paths(paths);
  check_heavy_data(options.out);
}

void convert(const ConvertOptions& options, const StopToken& stop) {
  check_places(options);
  warn_of_lost_origins(std::span(&options.in, 1));
  warn_of_unknown_systems(std::span(&options.in, 1));
  const bool mesh = is_mesh_file(options.in);
  if (options.normals_from_faces && !mesh)
    throw_bad_input("is no mesh, so there are no faces to take normals from",
                    {.file = options.in, .expected = "a .ply, .obj, .stl or .glb file with faces"});
  if ((!mesh || options.normals_from_faces) && is_mesh_only_format(options.out))
    throw_usage("a cloud cannot become a mesh by conversion",
                {.file = options.out,
                 .expected = "a .ply, .xyz or .csv name",
                 .advice = "'orbweave reconstruct' makes a mesh of a cloud."});
  const bool stays_mesh =
      options.normals_from_faces || (mesh && !is_cloud_only_format(options.out));
  if (stays_mesh && !SelectedSource(options.keys).takes_all())
    throw_usage("points are selected of a cloud, not of a mesh",
                {.file = options.in,
                 .advice = "Make a cloud of its vertices first: orbweave convert MESH cloud.xyz"});
  if (options.normals_from_faces) return convert_to_oriented_cloud(options);
  if (mesh && !is_cloud_only_format(options.out)) return convert_mesh(options);
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
  add_key_options(*command, kKeys, options->keys);
  add_selection_options(*command, options->keys);
  command->footer(
      "A mesh stays a mesh unless OUT is a format of clouds (.xyz, .csv) or\n"
      "--normals-from-faces is given.\n\n"
      "Example:\n  orbweave convert --normals-from-faces bunny.ply bunny_points.ply\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { convert(*options, stop); });
  });
}

}  // namespace orbweave
