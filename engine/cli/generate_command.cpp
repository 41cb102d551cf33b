// orbweave generate: clouds of known surfaces, and the surfaces themselves.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>

#include "engine/cli/commands.h"
#include "engine/cli/numbers.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "engine/synthetic/virtual_scanner.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/shown_text.h"
#include "io/system/atomic_file.h"
#include "io/system/path_roles.h"
#include "io/text/nearest_name.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;
constexpr int kMostScans = 255;

struct GenerateOptions {
  std::string shape;
  std::string points;
  std::string noise = "0";
  std::string density = "uniform";
  std::string seed = "1";
  std::string scans = "0";
  std::string misregistration = "0";
  bool separate = false;
  bool float_positions = false;
  std::string out;
  std::string truth;
};

Shape shape_of(const std::string& name) {
  if (const auto shape = shape_named(name)) return *shape;
  std::vector<std::string> names;
  for (Shape shape : all_shapes()) names.emplace_back(name_of(shape));
  throw_usage("unknown shape \"" + name + "\"",
              {.expected = "one of " + joined(names),
               .advice = "Did you mean '" + nearest_name(name, names) + "'?"});
}

SyntheticOptions synthetic_options(const GenerateOptions& given) {
  SyntheticOptions options;
  options.shape = shape_of(given.shape);
  options.points = count_argument("--points", given.points);
  options.noise = number_argument("--noise", given.noise);
  options.density_varying = given.density == "varying";
  options.seed = count_argument("--seed", given.seed);
  options.precision = given.float_positions ? ScalarType::kFloat32 : ScalarType::kFloat64;
  return options;
}

/// About as fine as the cloud, but not so fine that the mesh would not fit in memory.
std::uint32_t truth_resolution(std::uint64_t points) {
  return static_cast<std::uint32_t>(
      std::clamp(std::sqrt(static_cast<double>(points)), 64.0, 1024.0));
}

void write_points(PointSource& source, const std::string& path, const MeshWriterOptions& format,
                  const StopToken& stop) {
  const MeshHeader header{.vertices = source.declared_points().value_or(0),
                          .is_cloud = true,
                          .schema = source.schema()};
  const auto writer = open_mesh_writer(path, header, format);
  for (PointCloud batch; source.read(batch, kBatchPoints);) {
    check_interruption(stop);
    writer->write_vertices(batch);
  }
  writer->finish();
  note_written(path);
}

void say(const std::string& path, std::uint64_t points, double distance) {
  if (path != "-")
    std::cout << shown(path) << ": " << format_count(points) << " points, "
              << format_number(distance) << " apart\n";
}

VirtualScannerOptions scanner_options(const GenerateOptions& given) {
  VirtualScannerOptions options;
  options.surface = synthetic_options(given);
  options.scans =
      static_cast<int>(std::min<std::uint64_t>(count_argument("--scans", given.scans), 1'000'000));
  options.misregistration = number_argument("--misregistration", given.misregistration);
  return options;
}

/// "scans.ply" and "_2.ply" give "scans_2.ply"; a .gz behind the extension moves along.
std::string beside(const std::string& path, const std::string& ending, bool keep_extension) {
  std::filesystem::path stem = path;
  std::string extension = stem.extension().string();
  stem.replace_extension();
  if (extension == ".gz") {
    extension = stem.extension().string() + extension;
    stem.replace_extension();
  }
  return stem.string() + ending + (keep_extension ? extension : "");
}

std::string scan_file(const std::string& out, int scan) {
  return beside(out, "_" + std::to_string(scan), true);
}

std::string poses_file(const std::string& out) { return beside(out, ".conf", false); }

std::string pose_line(const std::string& path, const ScannerPose& pose) {
  std::string line = "bmesh " + std::filesystem::path(path).filename().string();
  for (int axis = 0; axis < 3; ++axis) line += " " + format_exact(pose.translation[axis]);
  for (const double part : pose.quaternion) line += " " + format_exact(part);
  return line + "\n";
}

void write_separate_scans(const VirtualScanner& scanner, const std::string& out,
                          const MeshWriterOptions& format, const StopToken& stop) {
  std::string poses;
  for (int scan = 0; scan < scanner.scans(); ++scan) {
    const std::string path = scan_file(out, scan);
    if (scanner.points(scan) == 0) {
      std::cout << shown(path) << ": not written, the scanner sees nothing from there\n";
      continue;
    }
    write_points(*scanner.scan(scan), path, format, stop);
    say(path, scanner.points(scan), scanner.ray_distance());
    poses += pose_line(path, scanner.pose(scan));
  }
  const std::string path = poses_file(out);
  AtomicFile file(path);
  file.write(poses);
  file.commit();
  note_written(path);
  std::cout << shown(path) << ": poses\n";
}

void generate_scans(const GenerateOptions& given, const MeshWriterOptions& format,
                    const StopToken& stop) {
  if (given.separate && given.out == "-")
    throw_usage("separate scans cannot go to standard output",
                {.advice = "Name a file: the scans' names are made from it."});
  const VirtualScanner scanner(scanner_options(given));
  if (given.separate) {
    write_separate_scans(scanner, given.out, format, stop);
    return;
  }
  write_points(*scanner.all(), given.out, format, stop);
  say(given.out, scanner.points(), scanner.ray_distance());
}

void generate_cloud(const GenerateOptions& given, const MeshWriterOptions& format,
                    const StopToken& stop) {
  if (given.separate || number_argument("--misregistration", given.misregistration) != 0.0)
    throw_usage("only scans are separate or misregistered", {.advice = "Add --scans K."});
  const SyntheticOptions options = synthetic_options(given);
  SyntheticCloud cloud(options);
  write_points(cloud, given.out, format, stop);
  say(given.out, options.points, spacing(options));
}

/// Every file that is going to be written.
void check_places(const GenerateOptions& given) {
  std::vector<PathRole> paths = {{"the true surface", given.truth, PathUse::kWrittenFile}};
  if (!given.separate) paths.push_back({"the cloud", given.out, PathUse::kWrittenFile});
  const int scans = given.separate && given.out != "-" ? scanner_options(given).scans : 0;
  for (int scan = 0; scan < std::min(scans, kMostScans); ++scan)
    paths.push_back(
        {"scan " + std::to_string(scan), scan_file(given.out, scan), PathUse::kWrittenFile});
  if (scans > 0)
    paths.push_back({"the file of poses", poses_file(given.out), PathUse::kWrittenFile});
  check_paths(paths);
}

void generate(const GenerateOptions& given, const StopToken& stop) {
  const SyntheticOptions options = synthetic_options(given);
  check_options(options);
  check_places(given);
  const MeshWriterOptions format{.float_positions = given.float_positions, .comments = {}};
  if (!given.truth.empty()) {
    write_mesh(given.truth, truth_mesh(options, truth_resolution(options.points)), format);
    note_written(given.truth);
  }
  count_argument("--scans", given.scans) > 0 ? generate_scans(given, format, stop)
                                             : generate_cloud(given, format, stop);
}

void add_options(CLI::App& command, GenerateOptions& options) {
  command
      .add_option("SHAPE", options.shape, "sphere, torus, bumpy-torus, plane, double-wall or cube")
      ->type_name("")
      ->required();
  command.add_option("--points", options.points, "How many, at least 1")
      ->type_name("N")
      ->required();
  command
      .add_option(
          "--noise", options.noise,
          "Deviation of the noise, in spacings of the points: of each coordinate, or along\n"
          "the rays of a scanner (0)")
      ->type_name("S");
  command.add_option("--density", options.density, "uniform, or varying 1:16 from end to end")
      ->check(CLI::IsMember({"uniform", "varying"}))
      ->type_name("WORD");
  command.add_option("--seed", options.seed, "Another seed, other noise, other poses (1)")
      ->type_name("N");
  command
      .add_option("--scans", options.scans,
                  "Raw scans instead: what a distant scanner sees from K sides, 1 to 255, of the\n"
                  "nearest surface alone, without normals; about N points together")
      ->type_name("K");
  command
      .add_option("--misregistration", options.misregistration,
                  "How far the pose of a scan moves its points, in spacings, root mean square (0)")
      ->type_name("S");
  command.add_flag(
      "--separate", options.separate,
      "Each scan in its scanner's frame, looking along -z: scans.ply gives scans_0.ply,\n"
      "scans_1.ply, ... and their poses, scans.conf");
  command.add_flag("--float", options.float_positions, "4-byte coordinates");
  command.add_option("-o,--output", options.out, "The cloud; - writes PLY to standard output")
      ->type_name("FILE")
      ->required();
  command.add_option("--truth", options.truth, "Write the exact surface as a mesh, too")
      ->type_name("FILE");
}

}  // namespace

void add_generate_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<GenerateOptions>();
  CLI::App* command = program.add_subcommand(
      "generate",
      "Make a cloud of a known surface, with exact normals or as raw scans, in any size");
  add_options(*command, *options);
  command->footer(
      "The same options give the same bytes on every machine.\n\nExample:\n"
      "  orbweave generate torus --points 200000 --noise 0.3 -o torus.ply --truth truth.ply\n"
      "  orbweave generate bumpy-torus --points 200000 --scans 14 --noise 0.2\n"
      "    --misregistration 0.5 --separate -o scans.ply\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { generate(*options, stop); });
  });
}

}  // namespace orbweave
