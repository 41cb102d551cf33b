// orbweave view: a mesh as one page for a browser, or as a folder of tiles, which it serves.
#include <oneapi/tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "engine/cli/commands.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/cli/view_folder.h"
#include "engine/levels/level_maker.h"
#include "engine/levels/levels.h"
#include "engine/validation/mesh_facts.h"
#include "engine/view/folder_server.h"
#include "engine/view/view_page.h"
#include "io/error.h"
#include "io/job/setting.h"
#include "io/json_nesting.h"
#include "io/meshes/mesh_reader.h"
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

constexpr std::array<std::string_view, 4> kKeys = {
    "partition.memory", "run.threads", "output.picture_up", "output.tileset_compression"};
/// Of a mesh that is simplified for its page.
constexpr std::uint64_t kMostShownTriangles = 300'000;

/// Of --serve where no port is named.
constexpr const char* kServe = "--serve{8080}";

struct ViewArguments {
  std::string mesh;  ///< or a tileset
  std::string page;
  std::string folder;
  std::string port;  ///< as given; empty: nothing is served
  std::string report;
  JobArguments keys;
};

/// What is shown, and what is said about it.
struct ShownMesh {
  TriangleMesh mesh;
  std::vector<std::string> facts;
  std::vector<float> confidence;  ///< of each triangle's patch; empty: not known
};

ShownMesh whole_mesh(const std::string& file) {
  ShownMesh shown{read_mesh(file), {}, face_confidence(file)};
  shown.facts = {show_mesh(mesh_facts(shown.mesh))};
  return shown;
}

/// Triangles of one patch come one after another.
void take_faces(const NodeMesh& mesh, ShownMesh& shown) {
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t t) { return mesh.tags[t].hole; });
  for (const std::uint32_t t : order) {
    shown.mesh.triangles.push_back(mesh.triangles[t]);
    shown.mesh.hole.push_back(mesh.tags[t].hole);
    shown.confidence.push_back(mesh.tags[t].confidence);
  }
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
  options.keeps_tags = true;
  const auto stream = open_mesh_stream(arguments.mesh);
  ShownMesh shown;
  LevelEvents events;
  events.read = [&](std::uint64_t triangles) { progress.advance(triangles); };
  events.done = [&](std::uint32_t node, const PointCloud& points, const NodeMesh& mesh) {
    if (node != 0) return;
    shown.mesh.vertices = points;
    take_faces(mesh, shown);
  };
  progress.begin_stage("simplify", stream->faces(), "triangles");
  const Levels levels = make_levels(*stream, options, events, stop);
  progress.end_stage();
  if (!stream->has_confidence()) shown.confidence.clear();
  shown.facts = {show_counts(levels.vertices, levels.triangles),
                 "shown: " + counted(shown.mesh.triangles.size(), "triangle", "triangles") +
                     ", at most about " + format_number(levels.facts[0].error) + " from the mesh"};
  return shown;
}

ShownMesh shown_mesh(const ViewArguments& arguments, const Job& job, Progress& progress,
                     const StopToken& stop) {
  const auto stream = open_mesh_stream(arguments.mesh);
  constexpr std::uint64_t kRoomForFacts = 500'000;
  const std::uint64_t bytes =
      view_page_bytes(stream->vertices(), stream->faces(), stream->schema());
  if (bytes + kRoomForFacts <= kMostPageBytes) return whole_mesh(arguments.mesh);
  return simplified_mesh(arguments, job, progress, stop);
}

/// Empty where none is asked for.
std::string report_text(const std::string& file) {
  if (file.empty()) return {};
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw_bad_input("no such file", {.file = file});
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (nests_too_deeply(text))
    throw_bad_input("the report is nested too deeply",
                    {.file = file, .expected = expected_json_levels()});
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

void write_page(const ViewArguments& arguments, const Job& job, const StopToken& stop) {
  const std::vector<PathRole> paths = {
      {"the mesh that is read", arguments.mesh, PathUse::kReadFile},
      {"the report that is read", arguments.report, PathUse::kReadFile},
      {"the page", arguments.page, PathUse::kWrittenFile}};
  check_paths(paths);
  check_page_name(arguments.page);
  if (tileset_folder(arguments.mesh))
    throw_usage("a page is made of a mesh, not of a folder of tiles",
                {.file = arguments.mesh,
                 .expected = "the file of a mesh",
                 .advice = "'orbweave view TILESET --folder DIR' shows a tileset."});
  ViewPage page;
  page.name = fs::path(arguments.mesh).filename().string();
  page.report = report_text(arguments.report);
  const auto progress = make_progress(progress_style(arguments.keys));
  const ShownMesh shown = shown_mesh(arguments, job, *progress, stop);
  page.facts = shown.facts;
  page.confidence = shown.confidence;
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

void write_folder(const ViewArguments& arguments, const Job& job, const StopToken& stop) {
  const bool is_tileset = tileset_folder(arguments.mesh).has_value();
  const std::vector<PathRole> paths = {
      {"the result that is read", tileset_folder(arguments.mesh).value_or(arguments.mesh),
       is_tileset ? PathUse::kReadDirectory : PathUse::kReadFile},
      {"the report that is read", arguments.report, PathUse::kReadFile},
      {"the folder", arguments.folder, PathUse::kWrittenDirectory},
      {"the work directory", arguments.folder + ".work", PathUse::kWorkDirectory}};
  check_paths(paths);
  const auto progress = make_progress(progress_style(arguments.keys));
  make_view_folder({arguments.mesh, arguments.folder, report_text(arguments.report)}, job,
                   *progress, stop);
}

std::uint16_t port_of(const std::string& text) {
  std::uint16_t port = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, port);
  if (error != std::errc() || stop != end)
    throw_usage("no such port",
                {.place = "--serve", .found = text, .expected = "a number from 0 to 65535"});
  return port;
}

void check_usage(const ViewArguments& arguments) {
  const bool serves = !arguments.port.empty(), makes_folder = !arguments.folder.empty();
  if (arguments.page.empty() && !makes_folder && !serves)
    throw_usage("nothing to make is named", {.expected = "-o PAGE.html, --folder DIR or --serve",
                                             .advice = "See 'orbweave view --help'."});
  if (!arguments.page.empty() && (makes_folder || serves))
    throw_usage("one page needs no folder and no server",
                {.found = makes_folder ? "-o and --folder" : "-o and --serve",
                 .expected = "one of them",
                 .advice = "Make the page by a command of its own."});
  if (serves && !makes_folder && !arguments.report.empty())
    throw_usage("a report is put into a folder that is made",
                {.found = "--report without --folder", .expected = "--folder DIR as well"});
}

/// Until a signal, which ends the process.
[[noreturn]] void serve(const FolderServer& server) {
  std::cout << "serving at http://127.0.0.1:" << server.port() << "/ until Ctrl-C" << std::endl;
  flush_output();
  const EndAtOnceOnSignals scope;
  server.serve();
}

/// Tiles that are there keep their bytes.
void check_compression(const ViewArguments& arguments, const Job& job) {
  if (job.output.tileset_compression == TileCompression::kNone) return;
  if (!arguments.folder.empty() && !tileset_folder(arguments.mesh)) return;
  throw_usage("no tiles are made that could be compressed",
              {.place = setting_name(job, "output.tileset_compression"),
               .expected = "a mesh, and --folder DIR"});
}

void view(const ViewArguments& arguments, const StopToken& stop) {
  check_usage(arguments);
  const bool makes_folder = !arguments.folder.empty();
  if (!makes_folder && arguments.page.empty())
    check_view_folder(tileset_folder(arguments.mesh).value_or(arguments.mesh));
  const Job job = settings_of(arguments.keys);
  check_compression(arguments, job);
  warn_of_lost_origins(std::span(&arguments.mesh, 1));
  const tbb::global_control limit(
      tbb::global_control::max_allowed_parallelism,
      static_cast<std::size_t>(std::max(job.run.threads, available_threads())));
  if (!arguments.page.empty()) return write_page(arguments, job, stop);
  // A port that is taken is found out before the work.
  std::optional<FolderServer> server;
  if (!arguments.port.empty())
    server.emplace(makes_folder ? fs::path(arguments.folder)
                                : tileset_folder(arguments.mesh).value_or(arguments.mesh),
                   port_of(arguments.port));
  if (makes_folder) write_folder(arguments, job, stop);
  if (server) serve(*server);
}

}  // namespace

void add_view_command(CLI::App& program, const CommandContext& context) {
  const auto arguments = std::make_shared<ViewArguments>();
  CLI::App* command = program.add_subcommand("view", "Show a mesh or a tileset in a browser");
  command
      ->add_option("RESULT", arguments->mesh,
                   "The mesh to show: PLY, OBJ, STL or GLB; or a tileset (--folder, --serve)")
      ->type_name("")
      ->required();
  command->add_option("-o,--output", arguments->page, "The page to write (HTML)")
      ->type_name("FILE");
  command->add_option("--folder", arguments->folder, "The folder of tiles and viewer to write")
      ->type_name("DIR");
  command->add_flag(kServe, arguments->port,
                    "Serve the folder on this machine until Ctrl-C (--serve=PORT; 8080, 0: any)");
  command->add_option("--report", arguments->report, "A report to show beside it (JSON)")
      ->type_name("FILE");
  add_key_options(*command, kKeys, arguments->keys);
  add_progress_option(*command, arguments->keys);
  command->footer(
      "The page is one file of at most 20 MB that needs no server and no network. A mesh that is\n"
      "too large for it is simplified. The folder has all of a mesh of any size, as 3D Tiles that\n"
      "the browser loads where it looks; any web server can serve it.\n\n"
      "Example:\n  orbweave view mesh.ply -o mesh.html --report mesh.report.json\n"
      "  orbweave view mesh.ply --folder mesh.view --serve\n"
      "  orbweave view mesh.view --serve=9000\n");
  command->callback([arguments, context] {
    context.then([arguments, &stop = context.stop] { view(*arguments, stop); });
  });
}

}  // namespace orbweave
