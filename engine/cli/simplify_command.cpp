// orbweave simplify: one mesh with fewer triangles, of a mesh of any size.
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/cli/commands.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/output_checks.h"
#include "engine/cli/signals.h"
#include "engine/levels/simplified_mesh.h"
#include "engine/levels/tileset_work.h"
#include "engine/pipeline/output/mesh_name.h"
#include "engine/pipeline/stage/writer_options.h"
#include "io/error.h"
#include "io/job/output_origin.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;
using Kind = SimplifyTarget::Kind;

constexpr std::array<std::string_view, 7> kKeys = {
    "output.mesh",       "output.format",    "output.precision", "output.origin",
    "output.picture_up", "partition.memory", "run.threads"};

/// An option of the command that says how far the mesh is simplified.
struct LimitOption {
  const char* name;
  Kind kind;
  const char* value;
  const char* help;
};
constexpr std::array kLimits = {
    LimitOption{"--ratio", Kind::kRatio, "R", "Keep at most this share of the triangles"},
    LimitOption{"--triangles", Kind::kTriangles, "N", "Keep at most so many triangles"},
    LimitOption{"--error", Kind::kError, "E",
                "Keep the two surfaces within this distance, in units of the mesh"}};

struct SimplifyArguments {
  std::string mesh;
  std::array<std::string, kLimits.size()> limits;  ///< as given
  std::uint64_t leaf_triangles = LevelOptions{}.leaf_triangles;
  JobArguments keys;
};

/// The one limit that was given.
SimplifyTarget target_of(const SimplifyArguments& arguments) {
  std::optional<SimplifyTarget> target;
  for (std::size_t i = 0; i < kLimits.size(); ++i) {
    const std::string& text = arguments.limits[i];
    if (text.empty()) continue;
    if (target)
      throw_usage("more than one limit of the simplification is given",
                  {.expected = "one of --ratio, --triangles and --error"});
    target = parse_simplify_target(std::string(kLimits[i].name + 2) + "=" + text);
    if (!target)
      throw_usage(std::string(kLimits[i].name) + " has an unsuitable value",
                  {.found = text, .expected = accepted_by(kLimits[i].kind)});
  }
  if (!target)
    throw_usage("how far the mesh is to be simplified is not said",
                {.expected = "one of --ratio, --triangles and --error",
                 .advice = "For a tenth of the triangles: --ratio 0.1"});
  return *target;
}

void check_places(const SimplifyArguments& arguments, const OutputOptions& output,
                  const fs::path& work) {
  check_mesh_name(output);
  if (output.mesh == "-")
    throw_usage("a simplified mesh is not written to standard output",
                {.expected = "the name of a file behind -o"});
  std::vector<PathRole> paths = files_of_mesh(output.mesh);
  paths.push_back({"the mesh that is read", arguments.mesh, PathUse::kReadFile});
  paths.push_back({"the work directory", work, PathUse::kWorkDirectory});
  check_paths(paths);
}

/// How the file is written; warns where its coordinates lose what matters.
MeshWriterOptions written_options(const SimplifyArguments& arguments, const Job& job,
                                  const std::string& system, const Box& bounds) {
  const bool floats = has_float_coordinates(job.output.mesh, writer_options(job.output, {}));
  const OutputOrigin chosen = output_origin(job.output, floats, bounds, 0.0);
  const std::string warning = check_output_origin(job, chosen);
  if (!warning.empty()) print_warning(warning);
  MeshWriterOptions options = writer_options(job.output, {}, chosen.origin);
  UpAxis up = job.output.picture_up;
  if (up == UpAxis::kAuto) up = up_axis_of_scans(std::span(&arguments.mesh, 1), system);
  options.up_axis = upright_axis(up, bounds);
  return options;
}

std::string summary(const OutputOptions& output, const SimplifiedFacts& facts,
                    const PointSchema& schema) {
  const double ratio =
      static_cast<double>(facts.triangles) / static_cast<double>(facts.triangles_read);
  Facts lines = {{"mesh", output.mesh},
                 {"", show_counts(facts.vertices, facts.triangles) + ": " + show_percent(ratio) +
                          " of " + format_count(facts.triangles_read)},
                 {"error", "at most " + format_number(facts.error)},
                 {"bytes", format_bytes(facts.bytes)}};
  if (facts.origin != Vec3{}) lines.emplace_back("origin", origin_text(facts.origin));
  std::vector<std::string> patches;
  if (facts.fills_holes) patches = patches_without_place(output.mesh, facts.has_confidence);
  const std::string left_out = left_out_of(output.mesh, schema, patches);
  if (!left_out.empty()) lines.emplace_back("left out", left_out);
  return facts_table(lines);
}

/// Reads, simplifies and writes, with progress. `schema`: becomes what the vertices carry.
SimplifiedFacts simplified(const SimplifyArguments& arguments, const SimplifyOptions& options,
                           const OutputOptions& output, Progress& progress, const StopToken& stop,
                           PointSchema& schema) {
  {  // What the stream holds goes before the work.
    const auto stream = open_mesh_stream(arguments.mesh);
    schema = stream->schema();
    warn_of_left_out(arguments.mesh, stream->left_out());
    progress.begin_stage("read", stream->faces(), "triangles");
  }
  SimplifyEvents events;
  events.read = [&](std::uint64_t triangles) { progress.advance(triangles); };
  events.planned = [&](std::uint32_t nodes) {
    progress.end_stage();
    progress.begin_stage("simplify", nodes, "nodes");
  };
  events.made = [&] { progress.advance(1); };
  events.begun = [&](std::uint64_t triangles) {
    progress.end_stage();
    progress.begin_stage("export", triangles, "triangles");
  };
  events.written = [&](std::uint64_t triangles) { progress.advance(triangles); };
  SimplifiedFacts facts;
  name_in_errors(arguments.mesh, [&] {
    facts = write_simplified(arguments.mesh, output.mesh, options, events, stop);
  });
  progress.end_stage();
  return facts;
}

void simplify(const SimplifyArguments& arguments, const StopToken& stop) {
  const Job job = settings_of(arguments.keys);
  const fs::path work_directory = job.output.mesh + ".work";
  SimplifyOptions options;
  options.target = target_of(arguments);
  check_places(arguments, job.output, work_directory);
  warn_of_lost_origins(std::span(&arguments.mesh, 1));
  warn_of_unknown_systems(std::span(&arguments.mesh, 1));
  options.levels.leaf_triangles = arguments.leaf_triangles;
  options.levels.memory_bytes = job.partition.memory_bytes;
  options.levels.threads = job.run.threads > 0 ? job.run.threads : available_threads();
  options.levels.directory = work_directory;
  PointSchema schema;
  const std::string system = coordinate_system_beside(arguments.mesh);
  options.written = [&](const Box& bounds) {
    return written_options(arguments, job, system, bounds);
  };
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(options.levels.threads, available_threads())));
  const auto progress = make_progress(progress_style(arguments.keys));
  const TilesetWork work(work_directory);
  const SimplifiedFacts facts = simplified(arguments, options, job.output, *progress, stop, schema);
  note_written(job.output.mesh);
  write_files_beside(job.output.mesh, arguments.mesh, system, facts.origin);
  if (const std::string missed = missed_limit(facts); !missed.empty()) print_warning(missed);
  std::cout << summary(job.output, facts, schema);
}

}  // namespace

void add_simplify_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<SimplifyArguments>();
  CLI::App* command =
      program.add_subcommand("simplify", "Write a mesh of any size with fewer triangles");
  command->add_option("MESH", arguments->mesh, "The mesh to read: PLY, OBJ, STL or GLB")
      ->type_name("")
      ->required();
  for (std::size_t i = 0; i < kLimits.size(); ++i)
    command->add_option(kLimits[i].name, arguments->limits[i], kLimits[i].help)
        ->type_name(kLimits[i].value);
  command
      ->add_option("--leaf-triangles", arguments->leaf_triangles,
                   "Most triangles that are simplified together at first (65536)")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 22));
  add_key_options(*command, kKeys, arguments->keys);
  add_progress_option(*command, arguments->keys);
  command->footer(
      "One of --ratio, --triangles and --error is needed. Vertices of the result are vertices of\n"
      "the mesh, with all that they carry; faces keep the holes that they fill.\n\n"
      "Example:\n  orbweave simplify mesh.ply -o small.ply --ratio 0.1\n");
  command->callback([arguments, context] {
    context.then([arguments, &stop = context.stop] { simplify(*arguments, stop); });
  });
}

}  // namespace orbweave
