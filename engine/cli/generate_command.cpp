// orbweave generate: clouds of known surfaces, and the surfaces themselves.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include "engine/cli/commands.h"
#include "engine/cli/generated_scans.h"
#include "engine/cli/numbers.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/synthetic/scene_scanner.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "engine/synthetic/virtual_scanner.h"
#include "io/error.h"
#include "io/meshes/mesh_writer.h"
#include "io/meshes/shift_file.h"
#include "io/system/path_roles.h"
#include "io/text/nearest_name.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

constexpr int kMostScans = 255;

struct GenerateOptions {
  std::string shape;
  std::string points;
  std::string noise = "0";
  std::string density = "uniform";
  std::string seed = "1";
  std::string scans;  ///< empty: no scans, but a cloud
  std::string misregistration = "0";
  std::string noise_growth = "0";
  bool undisturbed = false;
  bool separate = false;
  bool float_positions = false;
  std::string out;
  std::string truth;
};

Shape shape_of(const std::string& name) {
  if (const auto shape = shape_named(name)) return *shape;
  std::vector<std::string> names;
  for (const Shape shape : all_shapes()) names.emplace_back(name_of(shape));
  for (const SceneKind scene : all_scenes()) names.emplace_back(name_of(scene));
  throw_usage("unknown shape \"" + name + "\"",
              {.expected = "one of " + joined(names), .advice = advice_on_name(name, names)});
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

VirtualScannerOptions scanner_options(const GenerateOptions& given) {
  VirtualScannerOptions options;
  options.surface = synthetic_options(given);
  if (!given.scans.empty())
    options.scans = static_cast<int>(
        std::min<std::uint64_t>(count_argument("--scans", given.scans), 1'000'000));
  options.misregistration = number_argument("--misregistration", given.misregistration);
  return options;
}

/// The scans of a shape or of a scene, separate or in one file.
void write_scans(const RangeScans& scans, const GenerateOptions& given, PoseFile poses,
                 const PointFiles& files, const StopToken& stop) {
  if (given.separate)
    write_separate_scans(scans, given.out, poses, files, stop);
  else
    write_points(*scans.all(), given.out, files, stop);
}

void generate_scans(const GenerateOptions& given, const MeshWriterOptions& format,
                    const StopToken& stop) {
  const VirtualScanner scanner(scanner_options(given));
  write_scans(scanner, given, PoseFile::kStanford, {format, scanner.ray_distance()}, stop);
}

void generate_cloud(const GenerateOptions& given, const MeshWriterOptions& format,
                    const StopToken& stop) {
  if (given.separate || number_argument("--misregistration", given.misregistration) != 0.0)
    throw_usage("only scans are separate or misregistered", {.advice = "Add --scans K."});
  const SyntheticOptions options = synthetic_options(given);
  SyntheticCloud cloud(options);
  write_points(cloud, given.out, {format, spacing(options)}, stop);
}

/// Every file that is going to be written. `scans`: number of separate ones.
void check_places(const GenerateOptions& given, int scans, PoseFile poses) {
  if (given.separate && given.out == "-")
    throw_usage("separate scans cannot go to standard output",
                {.advice = "Name a file: the scans' names are made from it."});
  if (given.truth == "-")
    throw_usage("--truth: the true surface is not written to standard output",
                {.found = "-", .expected = "the name of a file"});
  std::vector<PathRole> paths = {{"the true surface", given.truth, PathUse::kWrittenFile}};
  if (!given.separate) paths.push_back({"the cloud", given.out, PathUse::kWrittenFile});
  if (given.separate && scans > 0)
    std::ranges::move(separate_scan_files(given.out, scans, poses), std::back_inserter(paths));
  check_paths(paths);
}

void write_truth(const TriangleMesh& truth, const std::string& path,
                 const MeshWriterOptions& format) {
  write_mesh(path, truth, format);
  write_shift(path, {});
  note_written(path);
}

void generate_shape(const GenerateOptions& given, const MeshWriterOptions& format,
                    const StopToken& stop) {
  for (const auto& [option, is_given] : {std::pair{"--noise-growth", given.noise_growth != "0"},
                                         std::pair{"--undisturbed", given.undisturbed}})
    if (is_given)
      throw_usage(std::string(option) + " is an option of scenes",
                  {.found = "shape \"" + given.shape + "\"",
                   .expected = "room, frames or house",
                   .advice = "Leave " + std::string(option) + " out."});
  const SyntheticOptions options = synthetic_options(given);
  check_options(options);
  const int scans = scanner_options(given).scans;
  check_places(given, std::min(scans, kMostScans), PoseFile::kStanford);
  if (!given.truth.empty())
    write_truth(truth_mesh(options, truth_resolution(options.points)), given.truth, format);
  given.scans.empty() ? generate_cloud(given, format, stop) : generate_scans(given, format, stop);
}

SceneScannerOptions scene_options(const GenerateOptions& given, SceneKind scene) {
  SceneScannerOptions options;
  options.scene = scene;
  options.points = count_argument("--points", given.points);
  options.noise = number_argument("--noise", given.noise);
  options.noise_growth = static_cast<int>(
      std::min<std::uint64_t>(count_argument("--noise-growth", given.noise_growth), 100));
  options.disturbances = !given.undisturbed;
  options.misregistration = number_argument("--misregistration", given.misregistration);
  options.seed = count_argument("--seed", given.seed);
  options.precision = given.float_positions ? ScalarType::kFloat32 : ScalarType::kFloat64;
  return options;
}

void generate_scene(const GenerateOptions& given, SceneKind scene, const MeshWriterOptions& format,
                    const StopToken& stop) {
  if (given.density != "uniform" || !given.scans.empty())
    throw_usage("scenes have scanners of their own",
                {.found = !given.scans.empty() ? "--scans" : "--density",
                 .expected = {},
                 .advice = "Leave --scans and --density out."});
  const SceneScanner scanner(scene_options(given, scene));
  const PoseFile poses = scanner.scanner(0) ? PoseFile::kJob : PoseFile::kStanford;
  check_places(given, scanner.scans(), poses);
  if (!given.truth.empty())
    write_truth(synthetic::truth_mesh(scanner.scene()), given.truth, format);
  write_scans(scanner, given, poses, {format, scanner.spacing()}, stop);
}

void generate(const GenerateOptions& given, const StopToken& stop) {
  const MeshWriterOptions format{.float_positions = given.float_positions, .comments = {}};
  if (const auto scene = scene_named(given.shape))
    generate_scene(given, *scene, format, stop);
  else
    generate_shape(given, format, stop);
}

void add_options(CLI::App& command, GenerateOptions& options) {
  command
      .add_option(
          "SHAPE", options.shape,
          "sphere, torus, bumpy-torus, plane, double-wall, cube, two-components (a sphere above a\n"
          "torus) or genus-3 (a plate with three holes); or a scene as raw scans:\n"
          "room (four tripods inside), frames (five of a depth camera in that room) or house\n"
          "(three lines of flight)")
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
      "scans_1.ply, ... and their poses, scans.conf; of room and frames a job file that has\n"
      "them, scans.toml");
  command
      .add_option("--noise-growth", options.noise_growth,
                  "Power of the distance with which the noise of a scene grows, 0 to 2 (0)")
      ->type_name("N");
  command.add_flag("--undisturbed", options.undisturbed,
                   "A scene without mixed pixels, walkers and leaves of trees");
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
      "    --misregistration 0.5 --separate -o scans.ply\n"
      "  orbweave generate room --points 1000000 --noise 0.2 --separate -o room.ply\n"
      "    --truth truth.ply && orbweave run room.toml\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { generate(*options, stop); });
  });
}

}  // namespace orbweave
