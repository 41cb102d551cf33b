// orbweave fill: the hole pass on a mesh from elsewhere.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <span>
#include <system_error>

#include "engine/cli/commands.h"
#include "engine/cli/file_kind.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/mesh_drawing.h"
#include "engine/cli/output.h"
#include "engine/cli/output_checks.h"
#include "engine/cli/signals.h"
#include "engine/holes/fill_mesh.h"
#include "engine/pipeline/output/mesh_name.h"
#include "engine/pipeline/stage/writer_options.h"
#include "engine/validation/doubled_border.h"
#include "engine/validation/mesh_crossings.h"
#include "engine/validation/mesh_facts.h"
#include "engine/validation/usable_mesh.h"
#include "engine/validation/usable_triangles.h"
#include "io/error.h"
#include "io/job/output_origin.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/mesh_stream.h"
#include "io/meshes/mesh_writer.h"
#include "io/points/color_depth.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/output_names.h"
#include "io/report/point_colors.h"
#include "io/report/progress.h"
#include "io/system/file_descriptor.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"
#include "io/text/words.h"

namespace orbweave {
namespace {

/// Keys of a job file that are options here, too; --report is another one (JSON alone).
constexpr std::array<std::string_view, 21> kKeys = {"output.mesh",
                                                    "fill.kernel",
                                                    "fill.neighborhood",
                                                    "fill.max_diameter",
                                                    "fill.max_perimeter",
                                                    "fill.max_edges",
                                                    "fill.keep_outer_border",
                                                    "fill.allow_intersections",
                                                    "fill.graded",
                                                    "fill.min_triangles",
                                                    "output.format",
                                                    "output.precision",
                                                    "output.origin",
                                                    "output.colors",
                                                    "output.confidence",
                                                    "output.picture",
                                                    "output.picture_up",
                                                    "output.picture_colors",
                                                    "output.picture_backs",
                                                    "output.patch_color",
                                                    "run.threads"};

struct FillArguments {
  std::string file;
  std::string report;
  JobArguments job;
};

/// Everything that can be known to go wrong before the work.
void check(const FillArguments& arguments, const OutputOptions& output) {
  const EndAtOnceOnSignals even_where_a_pipe_has_no_writer;
  check_mesh_name(output);
  if (output.picture_colors == PictureColors::kUndersampled)
    throw_usage("a mesh does not tell where its scan was undersampled",
                {.place = "--picture-colors",
                 .found = "undersampled",
                 .expected = "patches, confidence, points or component"});
  std::vector<PathRole> paths = files_of_mesh(output.mesh);
  paths.push_back({"the mesh that is read", arguments.file, PathUse::kReadFile});
  paths.push_back({"the report", output.report, PathUse::kWrittenFile});
  paths.push_back({"the picture", output.picture, PathUse::kWrittenFile});
  check_paths(paths);
  check_output_names(output, "--report");
  // A pipe is read only once: what it holds shows later.
  if (is_read_once(arguments.file) || is_mesh_file(arguments.file)) return;
  require_read_format(arguments.file);
  throw_bad_input("is no mesh, so it has no holes to fill",
                  {.file = arguments.file,
                   .expected = "a .ply, .obj, .stl or .glb file with faces",
                   .advice = "'orbweave reconstruct' makes a mesh of a cloud."});
}

std::string left_out_text(const UnusableTriangles& left_out) {
  std::vector<std::string> words;
  const auto add = [&](std::uint64_t count, const char* one, const char* many) {
    if (count > 0) words.push_back(counted(count, one, many));
  };
  add(left_out.degenerate, "triangle with two equal vertices", "triangles with two equal vertices");
  add(left_out.repeated, "repeated triangle", "repeated triangles");
  add(left_out.not_finite, "triangle with a coordinate that is not finite",
      "triangles with a coordinate that is not finite");
  return joined(words);
}

/// Takes out what is no surface, says so, and counts it in the report. True where there was any.
bool leave_out_unusable(TriangleMesh& mesh, FillReport& report, Progress& progress) {
  const UnusableTriangles left_out = remove_unusable_triangles(mesh);
  if (left_out.all() > 0) progress.warn(report.file + ": left out " + left_out_text(left_out));
  if (left_out.degenerate > 0) report.triangles_dropped["degenerate"] = left_out.degenerate;
  if (left_out.repeated > 0) report.triangles_dropped["repeated"] = left_out.repeated;
  if (left_out.not_finite > 0) report.triangles_dropped["not finite"] = left_out.not_finite;
  if (mesh.triangles.empty()) throw_bad_input("has no usable triangle", {.file = report.file});
  return left_out.all() > 0;
}

/// Meshes whose holes are not what they look like.
void warn_of_structure(const std::string& file, const TriangleMesh& mesh, const MeshFacts& facts,
                       Progress& progress) {
  const std::uint64_t doubled = facts.boundary_edges > 0 ? count_doubled_border(mesh) : 0;
  const std::string advice = "'orbweave convert' to .stl and back joins equal ones";
  if (facts.triangles > 1 && facts.boundary_edges == 3 * facts.triangles)
    progress.warn(file +
                  ": no triangle shares an edge with another one: every triangle brings its own "
                  "vertices. " +
                  advice);
  else if (doubled > 0)
    progress.warn(file + ": " + format_count(doubled) + " of " +
                  counted(facts.boundary_edges, "border edge", "border edges") +
                  " lie on one another: the surface goes on there, between vertices of the same "
                  "places, and loops run along them. " +
                  advice + ", without their attributes");
  if (facts.nonmanifold_edges + facts.inconsistent_edges > 0)
    progress.warn(file + ": " + counted(facts.nonmanifold_edges, "edge", "edges") +
                  " of more than two triangles and " +
                  counted(facts.inconsistent_edges, "edge", "edges") +
                  " of two triangles that are oriented differently; loops that run into one of "
                  "them stay open");
}

/// What faces of the mesh tell of earlier patches stays, and new patches get theirs.
void keep_confidence(const TriangleMesh& mesh, FillReport& report) {
  OutputOptions& output = report.options.output;
  std::error_code ignored;
  if (output.confidence || mesh.hole.empty() ||
      std::ranges::max(mesh.hole) > kMostIdWithConfidence ||
      !std::filesystem::is_regular_file(report.file, ignored))
    return;
  output.confidence = !hole_confidence(report.file).empty();
}

/// Reads the mesh, takes out what is no surface, and warns of what is odd.
TriangleMesh usable_mesh(FillReport& report, Progress& progress) {
  progress.begin_stage("read", 0, "triangles");
  std::vector<std::string> left_out_of_file;
  TriangleMesh mesh = read_usable_mesh(report.file, &left_out_of_file);
  const std::string not_carried_over = left_out_of_input(report.file, left_out_of_file);
  if (!not_carried_over.empty()) progress.warn(not_carried_over);
  require_room_for_ids(report.file, mesh);
  keep_confidence(mesh, report);
  if (const auto colors = wide_colors(mesh.vertices.schema))
    ColorDepth(mesh.vertices.schema, report.options.output.color_bits,
               exceed_8_bits(mesh.vertices, *colors))
        .apply(mesh.vertices);
  progress.advance(mesh.triangles.size());
  report.before = mesh_facts(mesh);
  report.before.crossing_pairs = count_crossing_pairs(mesh);
  const bool changed = leave_out_unusable(mesh, report, progress);
  warn_of_structure(report.file, mesh, changed ? mesh_facts(mesh) : report.before, progress);
  progress.end_stage();
  return mesh;
}

/// Reads, fills and measures; leaves nothing behind when it is ended.
TriangleMesh filled_mesh(FillReport& report, Progress& progress) {
  const EndAtOnceOnSignals no_need_to_clean_up;
  TriangleMesh mesh = usable_mesh(report, progress);
  const auto show = [&](std::uint64_t done, std::uint64_t holes) {
    done == 0 ? progress.begin_stage("holes", holes, "holes") : progress.advance(1);
  };
  FilledMesh filled = fill_mesh(std::move(mesh), report.options.fill, {.progress = show});
  report.holes = std::move(filled.holes);
  report.pieces_removed = filled.pieces_removed;
  report.triangles_removed = filled.triangles_removed;
  report.after = mesh_facts(filled.mesh);
  report.after.crossing_pairs = count_crossing_pairs(filled.mesh);
  report.after.mended_triangles = filled.triangles_mended;
  report.after.pinches = filled.pinches;
  progress.end_stage();
  return std::move(filled.mesh);
}

/// Where the coordinates of the mesh file are counted from; throws where they would lose too much.
void choose_origin(const TriangleMesh& mesh, FillReport& report, Progress& progress) {
  const OutputOptions& output = report.options.output;
  const bool floats = has_float_coordinates(output.mesh, writer_options(output, {}));
  const bool may_lose = floats || output.origin_rule == OriginRule::kGiven;
  const OutputOrigin chosen =
      output_origin(output, floats, report.after.bounds, may_lose ? vertex_spacing(mesh) : 0.0);
  const std::string warning = check_output_origin(report.options, chosen);
  if (!warning.empty()) progress.warn(warning);
  report.origin = chosen.origin;
}

/// `patches`: what faces carry and the format has no place for.
std::string summary(const FillReport& report, const PointSchema& schema,
                    const std::vector<std::string>& patches) {
  const OutputOptions& output = report.options.output;
  Facts facts = {{"mesh", output.mesh}, {"", show_mesh(report.after)}};
  add_holes(facts, report.holes, report.after, report.options);
  add_removed(facts, report.pieces_removed, report.triangles_removed);
  if (report.origin != Vec3{}) facts.emplace_back("origin", origin_text(report.origin));
  const std::string left_out = left_out_of(output.mesh, schema, patches);
  if (!left_out.empty()) facts.emplace_back("left out", left_out);
  if (!output.report.empty()) facts.emplace_back("report", output.report);
  if (!output.picture.empty()) facts.emplace_back("picture", output.picture);
  return facts_table(facts);
}

/// The confidence of patches by the ids of their holes, from 1 on: of those that are new, and of
/// those that the mesh came with as its file tells it. Empty where it is not asked for.
std::vector<float> known_confidence(const TriangleMesh& mesh, const FillReport& report) {
  const OutputOptions& output = report.options.output;
  const bool in_picture =
      !output.picture.empty() && output.picture_colors == PictureColors::kConfidence;
  if (!output.confidence && !in_picture) return {};
  const std::int32_t last = mesh.hole.empty() ? 0 : std::ranges::max(mesh.hole);
  if (last > kMostIdWithConfidence)
    throw_bad_input("the ids of filled holes are too large for their confidence to be kept",
                    {.file = report.file,
                     .place = "property hole of the faces",
                     .found = format_count(static_cast<std::uint64_t>(last)),
                     .expected = "at most " + format_count(kMostIdWithConfidence),
                     .advice = "Write the mesh without that property."});
  std::vector<float> confidence = confidence_of_patches(report.holes);
  const auto is_earlier = [&](std::int32_t id) {
    return id > 0 && (report.holes.empty() || id < report.holes.front().id);
  };
  // A stream cannot be read again: of its patches nothing is known, which is 1.
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(report.file, ignored) ||
      std::ranges::none_of(mesh.hole, is_earlier))
    return confidence;
  for (const auto& [id, value] : hole_confidence(report.file))
    if (id <= last && is_earlier(id)) note_confidence(confidence, id, value);
  return confidence;
}

/// The mesh last: where it is, all of it is.
void write_outputs(const TriangleMesh& mesh, const FillReport& report, Progress& progress) {
  const OutputOptions& output = report.options.output;
  const std::vector<float> confidence = known_confidence(mesh, report);
  if (!output.picture.empty()) {
    progress.begin_stage("picture", 0, "triangles");
    MeshDrawing drawing;
    drawing.picture.up = output.picture_up;
    drawing.picture.patch_color = output.patch_color;
    drawing.colors = output.picture_colors;
    drawing.backs = output.picture_backs;
    if (output.picture_colors == PictureColors::kConfidence)
      drawing.picture.confidence = confidence;
    if (output.picture_colors == PictureColors::kPoints && !PointColors(mesh.vertices.schema).any())
      progress.note(kNoPointColors);
    draw_mesh(mesh, output.picture, drawing);
    progress.advance(mesh.triangles.size());
    progress.end_stage();
    note_written(output.picture);
  }
  if (!output.report.empty()) {
    write_fill_report(output.report, report);
    note_written(output.report);
  }
  progress.begin_stage("export", 0, "triangles");
  MeshWriterOptions written = writer_options(output, {}, report.origin);
  written.confidence = confidence;
  written.up_axis = upright_axis(output.picture_up, report.after.bounds);
  write_mesh(output.mesh, mesh, written);
  progress.advance(mesh.triangles.size());
  progress.end_stage();
  note_written(output.mesh);
  write_files_beside(output.mesh, report.file, coordinate_system_beside(report.file),
                     report.origin);
}

void fill(const FillArguments& arguments, const std::vector<std::string>& command,
          const StopToken& stop) {
  FillReport report;
  report.version = ORBWEAVE_VERSION;
  report.command = command;
  report.options = settings_of(arguments.job);
  report.options.output.report = arguments.report;
  report.file = arguments.file;
  check(arguments, report.options.output);
  warn_of_lost_origins(std::span(&arguments.file, 1));
  warn_of_unknown_systems(std::span(&arguments.file, 1));
  const int threads =
      report.options.run.threads > 0 ? report.options.run.threads : available_threads();
  // More threads than cores are used when they are asked for.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(std::max(threads, available_threads())));
  const std::unique_ptr<Progress> progress = make_progress(progress_style(arguments.job));
  const auto begin = std::chrono::steady_clock::now();
  const TriangleMesh mesh =
      tbb::task_arena(threads).execute([&] { return filled_mesh(report, *progress); });
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  check_interruption(stop);
  choose_origin(mesh, report, *progress);
  write_outputs(mesh, report, *progress);
  const OutputOptions& output = report.options.output;
  if (output.mesh == "-") return;
  std::vector<std::string> patches;
  if (fills_holes(mesh)) patches = patches_without_place(output.mesh, output.confidence);
  std::cout << summary(report, mesh.vertices.schema, patches);
}

}  // namespace

void add_fill_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<FillArguments>();
  CLI::App* command = program.add_subcommand("fill", "Fill the holes of a mesh from anywhere");
  command
      ->add_option("MESH", arguments->file,
                   "The mesh to read: PLY, OBJ, STL or GLB; - reads PLY from standard input")
      ->type_name("")
      ->required();
  add_key_options(*command, kKeys, arguments->job);
  command->add_option("--report", arguments->report, "A report to write (JSON)")->type_name("FILE");
  add_progress_option(*command, arguments->job);
  command->footer(
      "Vertices of the mesh stay where they are; patches come after what was there. Pieces of\n"
      "fewer than --min-triangles triangles, and triangles that no patch can avoid, are taken out\n"
      "and counted. What stays open is printed with the reason. 'orbweave inspect MESH' lists the\n"
      "loops beforehand.\n\n"
      "Example:\n  orbweave fill scan.stl -o closed.ply --max-edges 500 --report closed.json\n");
  command->callback([arguments, context] {
    context.then([arguments, words = context.arguments, &stop = context.stop] {
      fill(*arguments, words, stop);
    });
  });
}

}  // namespace orbweave
