// orbweave inspect: the facts of a scan or a mesh.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "engine/cli/cloud_listing.h"
#include "engine/cli/commands.h"
#include "engine/cli/error_files.h"
#include "engine/cli/file_kind.h"
#include "engine/cli/files_beside.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/json_text.h"
#include "engine/cli/mesh_drawing.h"
#include "engine/cli/output.h"
#include "engine/cli/selected_source.h"
#include "engine/cli/signals.h"
#include "engine/cli/undersampled_listing.h"
#include "engine/holes/fill_mesh.h"
#include "engine/validation/cloud_facts.h"
#include "engine/validation/compare.h"
#include "engine/validation/doubled_border.h"
#include "engine/validation/mesh_crossings.h"
#include "engine/validation/mesh_facts.h"
#include "engine/validation/usable_mesh.h"
#include "engine/validation/usable_scale.h"
#include "engine/validation/usable_triangles.h"
#include "io/bounds.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/meshes/shift_file.h"
#include "io/points/coordinate_system_file.h"
#include "io/report/hole_summary.h"
#include "io/report/output_names.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/shown_text.h"
#include "io/system/file_descriptor.h"
#include "io/system/path_roles.h"
#include "io/text/quantity.h"

namespace orbweave {
namespace {

using Json = nlohmann::ordered_json;

struct InspectOptions {
  std::vector<std::string> files;
  std::string against;
  CompareOptions measures;  ///< with `against`
  ErrorFiles errors;        ///< likewise
  std::string picture;
  bool json = false;
  bool undersampled = false;
  JobArguments keys;  ///< those of kKeys

  UpAxis picture_up() const { return settings_of(keys).output.picture_up; }
};

/// Keys of a job file that are options here, too.
constexpr std::array<std::string_view, 3> kKeys = {"output.picture_up", "output.picture_backs",
                                                   "partition.memory"};

/// A large cloud is read twice; standard input and a pipe cannot be, so its spacing then stays
/// unknown.
CloudFacts facts_of_cloud(const std::string& file, const SelectedSource& selected) {
  const auto source = selected.open(file);
  if (const std::string faces = source->facts().faces; !faces.empty())
    print_warning(
        (file == "-" ? "standard input" : shown(file)) + " holds a mesh of " + faces +
        ", of which the points alone are inspected; a mesh is inspected whole from a file "
        "on disk");
  const auto again = is_read_once(file) ? nullptr : selected.open(file);
  CloudFacts facts;
  name_in_errors(file == "-" ? "standard input" : file,
                 [&] { facts = cloud_facts(*source, again.get()); });
  return facts;
}

/// What the facts of a mesh do not hold.
struct MeshFaults {
  std::uint64_t not_finite = 0;  ///< vertices
  std::uint64_t doubled = 0;     ///< boundary edges that lie on others
};

/// `system`: what lies beside the file says of its coordinates; may be empty.
std::string mesh_text(const MeshFacts& facts, const MeshFaults& faults, const std::string& system,
                      std::span<const std::string> not_read) {
  Facts lines = {{"kind", "mesh"},
                 {"vertices", format_count(facts.vertices)},
                 {"triangles", format_count(facts.triangles)},
                 {"bounds", show_box(facts.bounds)},
                 {"area", format_number(facts.area)},
                 {"watertight", facts.watertight ? "yes" : "no"},
                 {"components", format_count(facts.components)},
                 {"boundary", counted(facts.boundary_edges, "edge", "edges") + ", " +
                                  counted(facts.boundary_loops, "loop", "loops")},
                 {"non-manifold", counted(facts.nonmanifold_edges, "edge", "edges") + ", " +
                                      counted(facts.nonmanifold_vertices, "vertex", "vertices")},
                 {"Euler characteristic", std::to_string(facts.euler_characteristic)},
                 {"checksum", facts.checksum}};
  if (!system.empty()) lines.emplace_back("system", system_text(system));
  const auto add_fault = [&](const char* name, std::uint64_t count) {
    if (count > 0) lines.emplace_back(name, format_count(count));
  };
  if (faults.doubled > 0)
    lines.emplace_back("doubled border", counted(faults.doubled, "edge lies", "edges lie") +
                                             " on others: vertices of one place are not shared");
  add_fault("crossing pairs", facts.crossing_pairs.value_or(0));
  add_fault("inconsistent edges", facts.inconsistent_edges);
  add_fault("degenerate triangles", facts.degenerate_triangles);
  add_fault("duplicate triangles", facts.duplicate_triangles);
  add_fault("unreferenced vertices", facts.unreferenced_vertices);
  add_fault("vertices not finite", faults.not_finite);
  add_not_read(not_read, lines);
  return facts_table(lines);
}

void draw_cloud(const std::string& file, const Box& bounds, const InspectOptions& options) {
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  const auto source = SelectedSource(options.keys).open(file);
  const UpAxis implied = up_axis_of_scans({&file, 1}, source->coordinate_system());
  const UpAxis wanted = options.picture_up();
  MeshPicture picture(bounds, {.up = wanted == UpAxis::kAuto ? implied : wanted});
  for (PointCloud batch; source->read(batch, kBatchPoints);)
    picture.draw_points(batch.positions, batch.normals);
  picture.write_png(options.picture);
}

/// What the hole pass would make of the loops, with its defaults.
std::vector<HoleFacts> loops_of(TriangleMesh mesh, const MeshFacts& facts) {
  if (facts.boundary_edges == 0) return {};
  remove_unusable_triangles(mesh);
  return list_holes(mesh, FillOptions{});
}

std::string loops_text(std::span<const HoleFacts> holes) {
  constexpr std::size_t kShown = 8;
  if (holes.empty()) return "";
  std::vector<std::vector<std::string>> rows = {{holes.size() > kShown ? "widest loops" : "loops",
                                                 "edges", "diameter", "perimeter", "at vertex"}};
  for (const HoleFacts* hole : widest_holes(holes, kShown))
    rows.push_back({hole->reason.empty() ? "a hole" : "no hole: " + hole->reason,
                    format_count(hole->edges), format_number(hole->diameter),
                    format_number(hole->perimeter), format_count(hole->first_vertex)});
  std::string text = "\n" + table(rows);
  if (holes.size() > kShown)
    text += "and " + format_count(holes.size() - kShown) + " more; --json lists all\n";
  return text;
}

/// "1 x 4 x 3"; empty for an empty box.
std::string show_extent(const Box& box) {
  if (box.empty()) return "";
  const Vec3 extent = box.extent();
  return format_number(extent.x) + " x " + format_number(extent.y) + " x " +
         format_number(extent.z);
}

/// What is printed of a file.
struct Inspected {
  Json json;
  std::string text;
  std::vector<std::string> row;  ///< of the overview of several files
};

/// How a mesh lies to the cloud that the options name.
struct Against {
  CloudDistances distances;
  std::string colours;  ///< a line about the picture of errors
};

Against measure_against(const std::string& file, const TriangleMesh& mesh,
                        const InspectOptions& options) {
  const auto source = open_point_source(options.against);
  warn_of_two_systems(file, coordinate_system_beside(file), options.against,
                      source->coordinate_system());
  const PointCloud cloud = read_all(*source);
  require_usable_scale(options.against, "cloud", bounds_of_finite(cloud.positions));
  Against against;
  against.distances = distances_to_cloud(mesh, cloud, options.measures);
  if (options.errors.empty()) return against;
  TriangleMesh points;
  points.vertices.positions = cloud.positions;
  against.colours =
      write_errors(options.errors, mesh, vertex_distances(mesh, points), options.picture_up());
  return against;
}

std::string against_text(const Against& against) {
  const CloudDistances& distances = against.distances;
  return "\n" +
         distance_table({{"mesh to cloud, vertices", distances.mesh_to_cloud},
                         {"mesh to cloud, by area", distances.surface_to_cloud},
                         {"cloud to mesh", distances.cloud_to_mesh}}) +
         within_table(distances.within) + against.colours;
}

Json against_json(const Against& against, const std::string& file) {
  const CloudDistances& distances = against.distances;
  return {{"file", file},
          {"mesh_to_cloud", distance_json(distances.mesh_to_cloud)},
          {"surface_to_cloud", distance_json(distances.surface_to_cloud)},
          {"cloud_to_mesh", distance_json(distances.cloud_to_mesh)},
          {"within", within_json(distances.within)}};
}

Inspected inspect_mesh(const std::string& file, const InspectOptions& options) {
  std::vector<std::string> not_read;
  TriangleMesh mesh = read_usable_mesh(file, &not_read);
  MeshFacts facts = mesh_facts(mesh);
  facts.crossing_pairs = count_crossing_pairs(mesh);
  if (!options.picture.empty())
    draw_mesh(mesh, options.picture,
              {.picture = {.up = options.picture_up()},
               .backs = settings_of(options.keys).output.picture_backs});
  const MeshFaults faults{static_cast<std::uint64_t>(std::ranges::count_if(
                              mesh.vertices.positions, [](Vec3 p) { return !is_finite(p); })),
                          facts.boundary_edges > 0 ? count_doubled_border(mesh) : 0};
  std::optional<Against> against;
  if (!options.against.empty()) against = measure_against(file, mesh, options);
  const std::vector<HoleFacts> holes = loops_of(std::move(mesh), facts);
  Json json = Json::parse(mesh_facts_json(facts));
  json["holes"] = Json::parse(holes_json(holes));
  const std::string system = coordinate_system_beside(file);
  if (faults.not_finite > 0) json["not_finite"] = faults.not_finite;
  if (!system.empty()) json["coordinate_system"] = system;
  if (!not_read.empty()) json["not_read"] = not_read;
  if (against) json["against"] = against_json(*against, options.against);
  return {std::move(json),
          mesh_text(facts, faults, system, not_read) + (against ? against_text(*against) : "") +
              loops_text(holes),
          {"mesh",
           counted(facts.vertices, "vertex", "vertices") + ", " +
               counted(facts.triangles, "triangle", "triangles"),
           "", show_extent(facts.bounds), system.empty() ? "" : system_text(system)}};
}

void add_undersampling(const std::string& file, const CloudFacts& facts,
                       const InspectOptions& options, Json& json, std::string& text) {
  require_undersampling(settings_of(options.keys), facts.points);
  voronoi::Undersampling found;
  name_in_errors(
      file, [&] { found = undersampling_of(read_all(*SelectedSource(options.keys).open(file))); });
  json["undersampled"] = undersampled_json(found);
  text += undersampled_text(found);
}

Inspected inspect_cloud(const std::string& file, const InspectOptions& options) {
  if (!options.against.empty())
    throw_bad_input("a cloud has no distances to another cloud",
                    {.file = file, .expected = "a mesh before --against"});
  if (options.undersampled || !options.picture.empty()) require_rereadable(file);
  const CloudFacts facts = facts_of_cloud(file, SelectedSource(options.keys));
  if (!options.picture.empty()) draw_cloud(file, facts.bounds, options);
  Json json = cloud_json(facts);
  std::string text = cloud_text(facts);
  if (options.undersampled) add_undersampling(file, facts, options, json, text);
  return {std::move(json),
          std::move(text),
          {shown(format_text(facts.file)), counted(facts.points, "point", "points"),
           facts.spacing ? format_number(*facts.spacing) : "unknown", show_extent(facts.bounds),
           system_text(facts.coordinate_system)}};
}

Inspected inspect_file(const std::string& file, const InspectOptions& options) {
  if (!is_mesh_file(file)) return inspect_cloud(file, options);
  if (!SelectedSource(options.keys).takes_all())
    throw_usage("points are selected of a cloud, not of a mesh", {.file = file});
  if (options.undersampled)
    throw_usage("--undersampled looks at the points of a cloud, not at a mesh", {.file = file});
  return inspect_mesh(file, options);
}

void check_places(const InspectOptions& options) {
  std::vector<PathRole> paths = {{"the scan to compare with", options.against, PathUse::kReadFile},
                                 {"the picture", options.picture, PathUse::kWrittenFile}};
  check_error_files(options.errors);
  std::ranges::move(roles_of(options.errors), std::back_inserter(paths));
  for (const std::string& file : options.files)
    paths.push_back({"the file that is read", file, PathUse::kReadFile});
  check_paths(paths);
  check_picture_name(options.picture);
  std::vector<std::string> read = options.files;
  if (!options.against.empty()) read.push_back(options.against);
  require_once_each(read);
  if (options.files.size() > 1 && !options.picture.empty())
    throw_usage("--picture draws one file",
                {.found = std::to_string(options.files.size()) + " files",
                 .advice = "Inspect each file by a command of its own."});
  if (options.against.empty() && !(options.errors.empty() && options.measures.within.empty()))
    throw_usage("--within, --errors and --errors-picture measure a mesh against a cloud",
                {.advice = "Add --against CLOUD."});
  if (options.files.size() > 1 && !options.errors.empty())
    throw_usage("--errors writes one file",
                {.found = std::to_string(options.files.size()) + " files",
                 .advice = "Inspect each file by a command of its own."});
}

/// Files of the folder and of those in it that are read as clouds or meshes, by name. The shift of
/// a file is text, but no cloud.
std::vector<std::string> files_of_folder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<std::string> files;
  try {
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file() && is_scan_format(entry.path().filename().string()) &&
          !is_name_of_shift(entry.path()))
        files.push_back(entry.path().string());
  } catch (const fs::filesystem_error& problem) {
    throw_bad_input("cannot list the folder", {.file = folder, .found = problem.code().message()});
  }
  if (files.empty())
    throw_bad_input("holds no scan or mesh",
                    {.file = folder, .expected = "files of a format that is read"});
  std::ranges::sort(files);
  return files;
}

/// Folders as the files in them. Returns whether there was any.
bool expand_folders(std::vector<std::string>& names) {
  std::vector<std::string> files;
  bool has_folder = false;
  for (const std::string& name : names) {
    std::error_code ignored;
    if (std::filesystem::is_directory(name, ignored)) {
      has_folder = true;
      std::ranges::move(files_of_folder(name), std::back_inserter(files));
    } else {
      files.push_back(name);
    }
  }
  names = std::move(files);
  return has_folder;
}

/// What several files are like, one by one. One that cannot be read does not keep others from it.
class Overview {
 public:
  /// `shows_each`: prints the facts of each file, and not only a table of all.
  Overview(const InspectOptions& options, bool shows_each)
      : options_(options), shows_each_(shows_each && !options.json) {}

  void add(const std::string& file) {
    try {
      Inspected inspected = inspect_file(file, options_);
      inspected.json["file"] = file;
      list_.push_back(std::move(inspected.json));
      if (shows_each_)
        std::cout << (rows_.size() == 1 ? "" : "\n") << shown(file) << "\n"
                  << inspected.text << std::flush;
      inspected.row.insert(inspected.row.begin(), shown(file));
      rows_.push_back(std::move(inspected.row));
      has_any_ = true;
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::kBadInput) throw;
      if (first_) print_warning(error.what());
      if (!first_) first_ = error;
      list_.push_back({{"file", file}, {"error", error.what()}});
      rows_.push_back({shown(file), "error", "", "", "", ""});
    }
  }

  /// Throws the first error, when all else is told.
  void end() const {
    if (has_any_) {
      if (options_.json)
        std::cout << json_text(list_);
      else
        std::cout << (shows_each_ ? "\n" : "") << table(rows_) << std::flush;
    }
    if (first_) throw Error(*first_);
  }

 private:
  const InspectOptions& options_;
  bool shows_each_;
  bool has_any_ = false;
  Json list_ = Json::array();
  std::vector<std::vector<std::string>> rows_ = {
      {"file", "format", "size", "spacing", "extent", "system"}};
  std::optional<Error> first_;
};

/// One file: its facts. Several: those of each, and a table of all. A folder: the table alone.
void inspect(InspectOptions options) {
  end_at_once_on_signals();
  const bool has_folder = expand_folders(options.files);
  check_places(options);
  warn_of_lost_origins(options.files);
  warn_of_unknown_systems(options.files);
  warn_of_lost_origins(std::span(&options.against, 1));
  if (options.files.size() == 1 && !has_folder) {
    const Inspected inspected = inspect_file(options.files.front(), options);
    std::cout << (options.json ? json_text(inspected.json) : inspected.text);
    return;
  }
  Overview overview(options, !has_folder);
  for (const std::string& file : options.files) overview.add(file);
  overview.end();
}

}  // namespace

void add_inspect_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<InspectOptions>();
  CLI::App* command = program.add_subcommand(
      "inspect", "Show the facts of scans or meshes, and how a mesh lies to a cloud");
  command->add_option("FILE", options->files, "Scans or meshes, and folders of them")
      ->type_name("")
      ->required();
  command->add_flag("--json", options->json, "Print JSON");
  command->add_option("--against", options->against, "Distances from the mesh to a cloud and back")
      ->type_name("CLOUD");
  add_measure_options(*command, options->measures,
                      "with --against: share of the mesh's area that is at most so far from a "
                      "point (precision), and of the points from the mesh (recall)");
  add_error_options(*command, options->errors, "the mesh", "the cloud");
  command->add_flag("--undersampled", options->undersampled,
                    "List the places of a cloud that have too few points for their shape");
  command->add_option("--picture", options->picture, "Draw it (PNG)")->type_name("FILE");
  add_key_options(*command, kKeys, options->keys);
  CLI::Option* memory = command->get_option("--memory");
  memory->description(memory->get_description() + "; counts for --undersampled alone");
  add_selection_options(*command, options->keys);
  command->footer(
      "Example:\n  orbweave inspect scans/\n  orbweave inspect mesh.ply --against scan.ply "
      "--picture mesh.png\n");
  command->callback([options, context] { context.then([options] { inspect(*options); }); });
}

}  // namespace orbweave
