// orbweave inspect: the facts of a scan or a mesh.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "engine/cli/commands.h"
#include "engine/cli/error_files.h"
#include "engine/cli/file_kind.h"
#include "engine/cli/job_arguments.h"
#include "engine/cli/json_text.h"
#include "engine/cli/mesh_drawing.h"
#include "engine/cli/output.h"
#include "engine/cli/signals.h"
#include "engine/holes/fill_mesh.h"
#include "engine/validation/cloud_facts.h"
#include "engine/validation/compare.h"
#include "engine/validation/mesh_crossings.h"
#include "engine/validation/mesh_facts.h"
#include "engine/validation/usable_triangles.h"
#include "io/clouds/open_point_source.h"
#include "io/error.h"
#include "io/meshes/mesh_reader.h"
#include "io/report/hole_summary.h"
#include "io/report/picture.h"
#include "io/report/picture_up.h"
#include "io/shown_text.h"
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
  JobArguments keys;  ///< those of kKeys

  UpAxis picture_up() const { return settings_of(keys).output.picture_up; }
};

/// Keys of a job file that are options here, too.
constexpr std::array<std::string_view, 2> kKeys = {"output.picture_up", "output.picture_backs"};

/// A large cloud is read twice; standard input cannot be, so its spacing then stays unknown.
CloudFacts facts_of_cloud(const std::string& file) {
  const auto source = open_point_source(file);
  if (file == "-") return cloud_facts(*source);
  const auto again = open_point_source(file);
  return cloud_facts(*source, again.get());
}

template <class T>
Json json_or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json();
}

Json cloud_json(const CloudFacts& facts) {
  Json attributes = Json::array();
  for (const AttributeField& field : facts.attributes)
    attributes.push_back({{"name", field.name}, {"type", name_of(field.type)}});
  return {{"kind", "cloud"},
          {"points", facts.points},
          {"bounds", box_json(facts.bounds)},
          {"normals", facts.has_normals},
          {"position_type", name_of(facts.position_type)},
          {"attributes", attributes},
          {"spacing", json_or_null(facts.spacing)},
          {"spacing_of_six", json_or_null(facts.spacing_of_six)},
          {"duplicates", json_or_null(facts.duplicates)},
          {"not_finite", facts.not_finite},
          {"zero_normals", facts.zero_normals}};
}

std::string attribute_list(const CloudFacts& facts) {
  std::vector<std::string> words;
  for (const AttributeField& field : facts.attributes)
    words.push_back(field.name + " (" + name_of(field.type) + ")");
  return words.empty() ? "none" : joined(words);
}

std::string cloud_text(const CloudFacts& facts) {
  Facts lines = {{"kind", "cloud"},
                 {"points", format_count(facts.points)},
                 {"bounds", show_box(facts.bounds)},
                 {"coordinates", name_of(facts.position_type)},
                 {"normals", facts.has_normals ? "yes" : "no"},
                 {"attributes", attribute_list(facts)},
                 {"spacing", facts.spacing ? format_number(*facts.spacing) : "unknown"}};
  if (facts.duplicates.value_or(0) > 0)
    lines.emplace_back("duplicates", format_count(*facts.duplicates));
  if (facts.not_finite > 0) lines.emplace_back("not finite", format_count(facts.not_finite));
  if (facts.zero_normals > 0) lines.emplace_back("zero normals", format_count(facts.zero_normals));
  return facts_table(lines);
}

std::string mesh_text(const MeshFacts& facts) {
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
  const auto add_fault = [&](const char* name, std::uint64_t count) {
    if (count > 0) lines.emplace_back(name, format_count(count));
  };
  add_fault("crossing pairs", facts.crossing_pairs.value_or(0));
  add_fault("inconsistent edges", facts.inconsistent_edges);
  add_fault("degenerate triangles", facts.degenerate_triangles);
  add_fault("duplicate triangles", facts.duplicate_triangles);
  add_fault("unreferenced vertices", facts.unreferenced_vertices);
  return facts_table(lines);
}

void draw_cloud(const std::string& file, const Box& bounds, const InspectOptions& options) {
  constexpr std::size_t kBatchPoints = std::size_t{1} << 16;
  const auto source = open_point_source(file);
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

/// What is printed of a file: JSON or text.
struct Inspected {
  Json json;
  std::string text;
};

/// How a mesh lies to the cloud that the options name.
struct Against {
  CloudDistances distances;
  std::string colours;  ///< a line about the picture of errors
};

Against measure_against(const TriangleMesh& mesh, const InspectOptions& options) {
  const PointCloud cloud = read_all(*open_point_source(options.against));
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
  TriangleMesh mesh = read_mesh(file);
  MeshFacts facts = mesh_facts(mesh);
  facts.crossing_pairs = count_crossing_pairs(mesh);
  if (!options.picture.empty())
    draw_mesh(mesh, facts.bounds, options.picture, {.up = options.picture_up()},
              settings_of(options.keys).output.picture_backs == PictureBacks::kCulled);
  std::optional<Against> against;
  if (!options.against.empty()) against = measure_against(mesh, options);
  const std::vector<HoleFacts> holes = loops_of(std::move(mesh), facts);
  if (!options.json)
    return {{}, mesh_text(facts) + (against ? against_text(*against) : "") + loops_text(holes)};
  Json json = Json::parse(mesh_facts_json(facts));
  json["holes"] = Json::parse(holes_json(holes));
  if (against) json["against"] = against_json(*against, options.against);
  return {std::move(json), {}};
}

Inspected inspect_cloud(const std::string& file, const InspectOptions& options) {
  if (!options.against.empty())
    throw_bad_input("a cloud has no distances to another cloud",
                    {.file = file, .expected = "a mesh before --against"});
  const CloudFacts facts = facts_of_cloud(file);
  if (!options.picture.empty()) draw_cloud(file, facts.bounds, options);
  return options.json ? Inspected{cloud_json(facts), {}} : Inspected{{}, cloud_text(facts)};
}

Inspected inspect_file(const std::string& file, const InspectOptions& options) {
  return is_mesh_file(file) ? inspect_mesh(file, options) : inspect_cloud(file, options);
}

void check_places(const InspectOptions& options) {
  std::vector<PathRole> paths = {{"the scan to compare with", options.against, PathUse::kReadFile},
                                 {"the picture", options.picture, PathUse::kWrittenFile}};
  check_error_files(options.errors);
  std::ranges::move(roles_of(options.errors), std::back_inserter(paths));
  for (const std::string& file : options.files)
    paths.push_back({"the file that is read", file, PathUse::kReadFile});
  check_paths(paths);
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

/// One file: its facts. Several: a list of them, each with the name of its file.
void inspect(const InspectOptions& options) {
  end_at_once_on_signals();
  check_places(options);
  Json list = Json::array();
  for (const std::string& file : options.files) {
    Inspected inspected = inspect_file(file, options);
    if (options.files.size() == 1) {
      std::cout << (options.json ? json_text(inspected.json) : inspected.text);
      return;
    }
    if (options.json) {
      inspected.json["file"] = file;
      list.push_back(std::move(inspected.json));
    } else {
      std::cout << (file == options.files.front() ? "" : "\n") << shown(file) << "\n"
                << inspected.text << std::flush;
    }
  }
  if (options.json) std::cout << json_text(list);
}

}  // namespace

void add_inspect_command(CLI::App& program, const CommandContext& context) {
  auto options = std::make_shared<InspectOptions>();
  CLI::App* command = program.add_subcommand(
      "inspect", "Show the facts of scans or meshes, and how a mesh lies to a cloud");
  command->add_option("FILE", options->files, "Scans or meshes")->type_name("")->required();
  command->add_flag("--json", options->json, "Print JSON");
  command->add_option("--against", options->against, "Distances from the mesh to a cloud and back")
      ->type_name("CLOUD");
  add_measure_options(*command, options->measures,
                      "with --against: share of the mesh's area that is at most so far from a "
                      "point (precision), and of the points from the mesh (recall)");
  add_error_options(*command, options->errors, "the mesh", "the cloud");
  command->add_option("--picture", options->picture, "Draw it (PNG)")->type_name("FILE");
  add_key_options(*command, kKeys, options->keys);
  command->footer("Example:\n  orbweave inspect mesh.ply --against scan.ply --picture mesh.png\n");
  command->callback([options, context] { context.then([options] { inspect(*options); }); });
}

}  // namespace orbweave
