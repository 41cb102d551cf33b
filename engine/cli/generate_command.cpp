// orbweave generate: clouds of known surfaces, and the surfaces themselves.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "engine/cli/commands.h"
#include "engine/cli/numbers.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/synthetic/synthetic_cloud.h"
#include "io/error.h"
#include "io/mesh_writer.h"
#include "io/nearest_name.h"
#include "io/quantity.h"

namespace orbweave {
namespace {

constexpr std::size_t kBatchPoints = std::size_t{1} << 18;

struct GenerateOptions {
  std::string shape;
  std::string points;
  std::string noise = "0";
  std::string density = "uniform";
  std::string seed = "1";
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

void generate(const GenerateOptions& given, const StopToken& stop) {
  const SyntheticOptions options = synthetic_options(given);
  SyntheticCloud cloud(options);
  const MeshWriterOptions format{.float_positions = given.float_positions, .comments = {}};
  const MeshHeader header{.vertices = options.points, .is_cloud = true, .schema = cloud.schema()};
  const auto writer = open_mesh_writer(given.out, header, format);
  for (PointCloud batch; cloud.read(batch, kBatchPoints);) {
    check_interruption(stop);
    writer->write_vertices(batch);
  }
  if (!given.truth.empty())
    write_mesh(given.truth, truth_mesh(options, truth_resolution(options.points)), format);
  writer->finish();
  if (given.out != "-")
    std::cout << given.out << ": " << format_count(options.points) << " points, "
              << format_number(spacing(options)) << " apart\n";
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
      .add_option("--noise", options.noise,
                  "Deviation of each coordinate's noise, in spacings of the points (0)")
      ->type_name("S");
  command.add_option("--density", options.density, "uniform, or varying 1:16 from end to end")
      ->check(CLI::IsMember({"uniform", "varying"}))
      ->type_name("WORD");
  command.add_option("--seed", options.seed, "Another seed, other noise (1)")->type_name("N");
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
      "generate", "Make a cloud of a known surface, with exact normals, in any size");
  add_options(*command, *options);
  command->footer(
      "The same options give the same bytes on every machine.\n\nExample:\n"
      "  orbweave generate torus --points 200000 --noise 0.3 -o torus.ply --truth truth.ply\n");
  command->callback([options, context] {
    context.then([options, &stop = context.stop] { generate(*options, stop); });
  });
}

}  // namespace orbweave
