// orbweave view: a mesh as one page for a browser.
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/cli/commands.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/levels/level_maker.h"
#include "engine/levels/levels.h"
#include "engine/validation/mesh_facts.h"
#include "engine/view/view_page.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/meshes/vertex_colors.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/system/atomic_file.h"
#include "io/system/path_roles.h"
#include "io/system/temporary_name.h"
#include "io/text/quantity.h"
#include "partition/executor.h"

namespace orbweave {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 3> kKeys = {"partition.memory", "run.threads",
                                                   "output.picture_up"};
/// Of a mesh that is simplified for its page.
constexpr std::uint64_t kMostShownTriangles = 300'000;

struct ViewArguments {
  std::string mesh;
  std::string page;
  std::string report;
  JobArguments keys;
};

/// What is shown, and what is said about it.
struct ShownMesh {
  TriangleMesh mesh;
  std::vector<std::string> facts;
};

ShownMesh whole_mesh(const std::string& file) {
  ShownMesh shown{read_mesh(file), {}};
  shown.facts = {show_mesh(mesh_facts(shown.mesh))};
  return shown;
}

/// The coarsest of its levels.
ShownMesh simplified_mesh(const ViewArguments& arguments, const Job& job, Progress& progress,
                          const StopToken& stop) {
  LevelOptions options;
  options.memory_bytes = job.partition.memory_bytes;
  options.leaf_triangles =
      std::clamp<std::uint64_t>(most_leaf_triangles(options.memory_bytes), 1, kMostShownTriangles);
  options.threads = job.run.threads > 0 ? job.run.threads : available_threads();
  options.directory = directory_of(arguments.page);
  const auto stream = open_mesh_stream(arguments.mesh);
  ShownMesh shown;
  LevelEvents events;
  events.read = [&](std::uint64_t triangles) { progress.advance(triangles); };
  events.done = [&](std::uint32_t node, const PointCloud& points,
                    const std::vector<Triangle>& triangles) {
    if (node != 0) return;
    shown.mesh.vertices = points;
    shown.mesh.triangles = triangles;
  };
  progress.begin_stage("simplify", stream->faces(), "triangles");
  const Levels levels = make_levels(*stream, options, events, stop);
  progress.end_stage();
  shown.facts = {
      format_count(levels.vertices) + " vertices, " + format_count(levels.triangles) + " triangles",
      "shown: " + format_count(shown.mesh.triangles.size()) + " triangles, at most about " +
          format_number(levels.facts[0].error) + " from the mesh"};
  return shown;
}

ShownMesh shown_mesh(const ViewArguments& arguments, const Job& job, Progress& progress,
                     const StopToken& stop) {
  const auto stream = open_mesh_stream(arguments.mesh);
  const bool has_colors = VertexColors(stream->schema()).all_are_there();
  constexpr std::uint64_t kRoomForFacts = 500'000;
  const std::uint64_t bytes = view_page_bytes(stream->vertices(), stream->faces(), has_colors);
  if (bytes + kRoomForFacts <= kMostPageBytes) return whole_mesh(arguments.mesh);
  return simplified_mesh(arguments, job, progress, stop);
}

/// Empty where none is asked for.
std::string report_text(const std::string& file) {
  if (file.empty()) return {};
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream || !nlohmann::json::accept(text))
    throw_bad_input("cannot be read as a report", {.file = file, .expected = "a file in JSON"});
  return text;
}

/// A mistyped name must not cost a scan or a mesh.
void check_page_name(const std::string& page) {
  const std::string extension = fs::path(page).extension().string();
  if (extension == ".html" || extension == ".htm") return;
  throw_usage("a page is an HTML file", {.file = page,
                                         .found = extension.empty() ? "no extension" : extension,
                                         .expected = "a name that ends in .html or .htm"});
}

void view(const ViewArguments& arguments, const StopToken& stop) {
  const std::vector<PathRole> paths = {
      {"the mesh that is read", arguments.mesh, PathUse::kReadFile},
      {"the report that is read", arguments.report, PathUse::kReadFile},
      {"the page", arguments.page, PathUse::kWrittenFile}};
  check_paths(paths);
  check_page_name(arguments.page);
  const Job job = settings_of(arguments.keys);
  ViewPage page;
  page.name = fs::path(arguments.mesh).filename().string();
  page.report = report_text(arguments.report);
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(job.run.threads, available_threads())));
  const auto progress = make_progress(progress_style(arguments.keys));
  const ShownMesh shown = shown_mesh(arguments, job, *progress, stop);
  page.facts = shown.facts;
  UpAxis up = job.output.picture_up;
  if (up == UpAxis::kAuto)
    up = up_axis_of_scans(std::span(&arguments.mesh, 1), coordinate_system_beside(arguments.mesh));
  page.up_axis = upright_axis(up, shown.mesh.vertices.bounds());
  const std::string text = view_page(shown.mesh, page);
  if (text.size() > kMostPageBytes)
    throw_resource("the page would be too large for a browser",
                   {.file = arguments.page,
                    .found = format_bytes(text.size()),
                    .expected = "at most " + format_bytes(kMostPageBytes),
                    .advice = "Rims of open holes cannot be simplified. Make tiles: orbweave "
                              "tileset MESH -o DIR"});
  AtomicFile file(arguments.page);
  file.write(text);
  file.commit();
  note_written(arguments.page);
  Facts facts = {{"page", arguments.page}};
  for (const std::string& line : page.facts) facts.emplace_back("", line);
  std::cout << facts_table(facts);
}

}  // namespace

void add_view_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<ViewArguments>();
  CLI::App* command =
      program.add_subcommand("view", "Make one page of a mesh, which a browser shows");
  command->add_option("MESH", arguments->mesh, "The mesh to show: PLY, OBJ or STL")
      ->type_name("")
      ->required();
  command->add_option("-o,--output", arguments->page, "The page to write (HTML)")
      ->type_name("FILE")
      ->required();
  command->add_option("--report", arguments->report, "A report to show beside it (JSON)")
      ->type_name("FILE");
  add_key_options(*command, kKeys, arguments->keys);
  add_progress_option(*command, arguments->keys);
  command->footer(
      "The page is one file of at most 20 MB that needs no server and no network. A mesh that is\n"
      "too large for it is simplified.\n\n"
      "Example:\n  orbweave view mesh.ply -o mesh.html --report mesh.report.json\n");
  command->callback([arguments, context] {
    context.then([arguments, &stop = context.stop] { view(*arguments, stop); });
  });
}

}  // namespace orbweave
